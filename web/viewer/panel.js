// Parts of the panel that depend on the file.
const make = (tag, properties = {}, ...children) => {
    const node = Object.assign(document.createElement(tag), properties);
    node.append(...children);
    return node;
};

export function showModes(parent, halflight, redraw) {
    const rows = halflight.modes.map((mode) => {
        const radio = make('input', { type: 'radio', name: 'mode', value: mode });
        radio.addEventListener('input', () => {
            halflight.mode = mode;
            redraw();
        });
        return make('label', {}, radio, make('span', { textContent: mode }));
    });
    parent.replaceChildren(...rows);
}

/** A switch and a factor on the intensity of each light. */
export function showLights(parent, halflight, redraw) {
    const rows = halflight.lights.map((state) => {
        const intensity = state.light.intensity;
        const on = make('input', { type: 'checkbox', checked: true });
        const factor = make('input', { type: 'range', min: '0', max: '3', step: '0.05', value: '1', title: 'intensity' });
        const apply = () => {
            state.light.intensity = on.checked ? intensity * Number(factor.value) : 0;
            redraw();
        };
        on.addEventListener('input', apply);
        factor.addEventListener('input', apply);
        const kind = state.data.bakeType;
        const name = make('span', { textContent: state.name, title: `${state.name}: ${kind}` });
        if (kind === 'baked') on.disabled = factor.disabled = true; // its light is in the lightmap
        return make('label', {}, on, name, factor);
    });
    parent.replaceChildren(...rows);
}

const megabytes = (bytes) => `${(bytes / 1e6).toFixed(2)} MB`;

export function showStatistics(parent, { halflight, bytes }, renderer, seconds) {
    const parts = halflight.data.bytes;
    const page = halflight.data.lightmaps[0];
    const rows = [
        ['file', megabytes(bytes)],
        [`lightmaps${page ? `, ${halflight.data.lightmaps.length} × ${page.width} × ${page.height}` : ''}`, megabytes(parts.lightmaps)],
        ['shadowmasks', megabytes(parts.masks)],
        ['directions', megabytes(parts.directions)],
        [`probes, ${halflight.data.probes?.count ?? 0}`, megabytes(parts.probes)],
        ['objects', String(halflight.objects.length)],
        ['draw calls', String(renderer.info.render.calls)],
        ['triangles', renderer.info.render.triangles.toLocaleString('en')],
        ['time to submit', `${(1000 * seconds).toFixed(1)} ms`],
    ];
    parent.replaceChildren(...rows.map(([name, value]) => make('tr', {}, make('td', { textContent: name }), make('td', { textContent: value }))));
}
