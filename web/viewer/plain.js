// Files that are not baked, as the plug-in draws them: no object has baked light, and all lights are realtime. Of their
// extras it takes the colours of the sky and who casts shadows (docs/guide/lights-and-objects.md).
const BAKE = 'HALFLIGHT_mixed_lighting';

/** A colour of extras, a number or three; null where there is none. */
function colorOf(value) {
    const color = typeof value === 'number' ? [value, value, value] : value;
    const isColor = Array.isArray(color) && color.length === 3 && color.every((x) => x >= 0 && x <= 1e9);
    return isColor ? color : null;
}

function skyOf({ extras = {} } = {}) {
    const colors = ['zenith', 'horizon', 'ground'].map((part) => [
        part,
        colorOf(extras[`halflight_sky_${part}`]) ?? colorOf(extras.halflight_sky) ?? [0, 0, 0],
    ]);
    return Object.fromEntries(colors);
}

function addSwitches(object, extension) {
    const { halflight_cast_shadows: casts = 1, halflight_receive_shadows: receives = 1 } = object.extras ?? {};
    if (casts && receives) return;
    const switches = { castShadows: Boolean(casts), receiveShadows: Boolean(receives) };
    object.extensions = { ...object.extensions, [extension]: { ...object.extensions?.[extension], ...switches } };
}

/** Makes a plain document one that the plug-in draws. @param {any} json @returns {boolean} whether it is plain */
export function drawPlain(json) {
    if (json.extensions?.[BAKE] !== undefined) return false;
    const sky = skyOf(json.scenes?.[json.scene ?? 0]);
    json.extensions = { ...json.extensions, [BAKE]: { version: 2, mode: 'baked-indirect', sky } };
    for (const node of json.nodes ?? []) addSwitches(node, 'HALFLIGHT_node');
    for (const material of json.materials ?? []) addSwitches(material, 'HALFLIGHT_material');
    return true;
}
