// Lighting modes at run time, in the order of the kMode constants of shading/law.h, and debug views.
export const MODES = ['realtime', 'baked-indirect', 'shadowmask', 'distance-shadowmask', 'subtractive'];
export const VIEWS = ['lit', 'shadowmask', 'lightmap', 'probes', 'fade', 'overlap'];

const FITTING = {
    'baked-indirect': ['baked-indirect', 'realtime'],
    shadowmask: ['shadowmask', 'distance-shadowmask', 'baked-indirect', 'realtime'],
    subtractive: ['subtractive', 'realtime'],
};

/** Throws one sentence where the bake holds no data for a mode. @param {import('../file/read.js').BakedData} data */
export function checkMode(mode, data) {
    if (!MODES.includes(mode)) throw new Error(`there is no mode "${mode}": it is one of ${MODES.join(', ')}`);
    const modes = FITTING[data.mode];
    if (!modes.includes(mode))
        throw new Error(`the file was baked for ${data.mode}, so it can only be drawn in mode ${modes.join(' or ')}`);
    const channels = [...data.lights.values()].some((light) => light.channel >= 0);
    if (mode.endsWith('shadowmask') && channels && data.masks.length < data.lightmaps.length * data.maskLayers)
        throw new Error('the file has lights with shadowmask channels but lacks shadowmask pages');
}
