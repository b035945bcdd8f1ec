// Parts of the panel that depend on the file.
import { Color } from 'three';

import { legendOf } from './views.js';

const make = (tag, properties = {}, ...children) => {
    const node = Object.assign(document.createElement(tag), properties);
    node.append(...children);
    return node;
};

/** @param {(mode: string) => void} choose */
export function showModes(parent, halflight, choose) {
    const rows = halflight.modes.map((mode) => {
        const radio = make('input', { type: 'radio', name: 'mode', value: mode });
        radio.addEventListener('input', () => choose(mode));
        return make('label', {}, radio, make('span', { textContent: mode }));
    });
    parent.replaceChildren(...rows);
}

/** Of a weight: its largest channel, and what it has of that by channel; of a group that is off the colour stays. */
function split(weight, last) {
    const brightness = Math.max(...weight);
    return { brightness, tint: brightness > 0 ? weight.map((x) => x / brightness) : last };
}

/**
 * A colour and a brightness of each light group.
 * @returns {() => void} shows the weights that the groups have now
 */
export function showGroups(parent, halflight, redraw) {
    const rows = halflight.lightGroups.map(({ name, savedWeight }) => {
        let { tint } = split(savedWeight, [1, 1, 1]);
        const most = Math.max(2, 2 * Math.max(...savedWeight));
        const color = make('input', { type: 'color', ariaLabel: `Colour of ${name}` });
        const range = { type: 'range', min: '0', max: String(most), step: String(most / 200) };
        const brightness = make('input', { ...range, ariaLabel: `Brightness of ${name}` });
        const value = make('output');
        const apply = () => {
            halflight.setLightGroup(
                name,
                tint.map((x) => x * Number(brightness.value))
            );
            redraw();
        };
        color.addEventListener('input', () => {
            tint = new Color(color.value).toArray();
            apply();
        });
        brightness.addEventListener('input', apply);
        const sync = ({ weight }) => {
            const now = split(weight, tint);
            tint = now.tint;
            const hex = `#${new Color().setRGB(...tint).getHexString()}`;
            if (color.value !== hex) color.value = hex;
            const isApart = Math.abs(Number(brightness.value) - now.brightness) > most / 400;
            if (isApart) brightness.value = String(now.brightness);
            value.textContent = `× ${now.brightness.toFixed(2)}`;
        };
        const head = make('label', {}, make('span', { textContent: name }), color);
        const slider = make('label', {}, make('span', { textContent: 'brightness' }), value, brightness);
        return { row: make('div', {}, head, slider), sync };
    });
    parent.replaceChildren(...rows.map(({ row }) => row));
    const sync = () => halflight.lightGroups.forEach((group, i) => rows[i].sync(group));
    sync();
    return sync;
}

/** A switch and a factor on the intensity of each light. */
export function showLights(parent, halflight, redraw) {
    const rows = halflight.lights.map((state) => {
        const { intensity } = state.light;
        const kind = state.data.bakeType;
        const group = halflight.lightGroups[state.data.group];
        if (group) {
            const part = make('p', { textContent: `of light group ${group.name}` });
            return make('div', {}, make('span', { textContent: state.name }), part);
        }
        const on = make('input', { type: 'checkbox', checked: true });
        const name = make('label', {}, on, make('span', { textContent: state.name }));
        if (kind === 'baked') {
            on.disabled = true;
            return make('div', {}, name, make('p', { textContent: 'baked: its light is in the lightmap' }));
        }
        const factor = make('input', {
            type: 'range',
            min: '0',
            max: '3',
            step: '0.05',
            value: '1',
            ariaLabel: `Intensity of ${state.name}`,
        });
        const value = make('output', { textContent: '× 1.00' });
        const apply = () => {
            state.light.intensity = on.checked ? intensity * Number(factor.value) : 0;
            value.textContent = `× ${Number(factor.value).toFixed(2)}`;
            redraw();
        };
        on.addEventListener('input', apply);
        factor.addEventListener('input', apply);
        return make('div', {}, name, make('label', {}, make('span', { textContent: kind }), value, factor));
    });
    parent.replaceChildren(...rows);
}

export function showLegend(parent, halflight) {
    const [sentence, colors] = legendOf(halflight);
    const swatch = (color) => {
        const box = make('i');
        box.style.background = color;
        return box;
    };
    const list = make(
        'ul',
        {},
        ...colors.map(([color, text]) => make('li', {}, swatch(color), make('span', { textContent: text })))
    );
    parent.replaceChildren(
        ...(sentence ? [make('p', { textContent: sentence })] : []),
        ...(colors.length > 0 ? [list] : [])
    );
}

/** Equal sentences are not announced again. @param {string[]} sentences */
export function showNotes(parent, sentences) {
    if ([...parent.children].map((row) => row.textContent).join('\n') === sentences.join('\n')) return;
    parent.replaceChildren(...sentences.map((sentence) => make('li', { textContent: sentence })));
}

const megabytes = (bytes) => `${(bytes / 1e6).toFixed(2)} MB`;

export function showStatistics(parent, { halflight, bytes }, drawn, seconds) {
    const parts = halflight.data.bytes;
    const page = halflight.data.lightmaps[0];
    const groups = halflight.lightGroups.length;
    const rows = [
        ['file', megabytes(bytes)],
        [
            `lightmaps${page ? `, ${halflight.data.lightmaps.length} × ${page.width} × ${page.height}` : ''}`,
            megabytes(parts.lightmaps),
        ],
        ['shadowmasks', megabytes(parts.masks)],
        ['directions', megabytes(parts.directions)],
        ...(groups > 0 ? [[`light groups, ${groups}`, megabytes(parts.groups)]] : []),
        [`probes, ${halflight.data.probes?.count ?? 0}`, megabytes(parts.probes)],
        ['objects', String(halflight.objects.length)],
        ['draw calls', String(drawn.calls)],
        ['triangles', drawn.triangles.toLocaleString('en')],
        ['time to submit a frame', `${(1000 * seconds).toFixed(1)} ms`],
    ];
    parent.replaceChildren(
        ...rows.map(([name, value]) =>
            make('tr', {}, make('th', { scope: 'row', textContent: name }), make('td', { textContent: value }))
        )
    );
}
