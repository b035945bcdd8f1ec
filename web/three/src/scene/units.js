// Texture units of fragment shaders: each shadow map takes one, in every material of a scene, whichever file it is of.
// Where there are too few, the lights that are smallest at the camera go without a realtime shadow.

/** Files whose objects are below one object, by that object. @type {WeakMap<object, Set<import('./scene.js').HalflightScene>>} */
const files = new WeakMap();

/** Textures by material, for its version. */
const counted = new WeakMap();

/** How many textures a material has. @param {any} material */
export function texturesOf(material) {
    const known = counted.get(material);
    if (known?.version === material.version) return known.count;
    const count = Object.values(material).filter((value) => value?.isTexture).length;
    counted.set(material, { version: material.version, count });
    return count;
}

/** @param {import('./scene.js').HalflightScene} scene @param {any} top above all that is drawn, or null */
export function enterFile(scene, top) {
    if (scene.top === top) return;
    files.get(scene.top)?.delete(scene);
    scene.top = top;
    if (top) files.set(top, (files.get(top) ?? new Set()).add(scene));
}

/** Other files in the scene that a file is in, as far as they were drawn. @param {import('./scene.js').HalflightScene} scene */
export function filesBeside(scene) {
    return [...(files.get(scene.top) ?? [])].filter((other) => other !== scene && other.backend);
}

const SHARPNESS = 512; // steps of importance in which lights count as equal, for each doubling

/** A light keeps its map until another is this much larger at the camera, in steps: else maps would come and go as it moves. */
const HELD = 64;

/** A light that has a map, or had one, before the others. */
function rankOf(state, camera) {
    const importance = state.importance(camera);
    return Math.round(SHARPNESS * Math.log2(Math.max(importance, 1e-30))) + (state.mapAllowed ? HELD : 0);
}

/** Whether three.js gives it to the shaders. @param {any} mask layers of the light */
const isDrawn = (light, mask, camera) => (mask & camera.layers.mask) !== 0 && light.isLight;

/**
 * Decides which of the files' lights may have a shadow map: `mapAllowed`. Of other files maps are only taken here: they
 * get them by their own update().
 * @param {import('./frame_lights.js').FrameLights} frameLights @param {any} camera @param {any[]} drawn visible lights below the top
 * @param {number} units of a fragment shader @param {number} taken by what the scene has for all materials
 * @param {number} perMap units that a shadow map takes
 */
export function limitMaps(frameLights, camera, drawn, { units, taken, perMap }) {
    const all = new Map();
    let own = 0;
    for (const scene of [frameLights.scene, ...filesBeside(frameLights.scene)]) {
        own = Math.max(own, scene.backend.samplers());
        for (const [light, state] of scene.frameLights.states) all.set(light, { state, scene });
    }
    const wanting = [];
    for (const light of drawn) {
        const { state, scene } = all.get(light) ?? {};
        if (!state) {
            if (isDrawn(light, light.layers.mask, camera)) taken += (light.castShadow ? perMap : 0) + (light.map ? 1 : 0);
        } else if (state.plan.drawn && isDrawn(light, state.before.layers, camera)) {
            if (light.map) taken += 1;
            if (scene.frameLights.wantsMap(state)) wanting.push({ state, scene, rank: rankOf(state, camera) });
        }
    }
    const most = Math.max(Math.floor((units - own - taken) / perMap), 0);
    for (const state of frameLights.states.values()) state.mapAllowed = true;
    if (wanting.length <= most) return;
    wanting.sort((a, b) => b.rank - a.rank || (a.state.name < b.state.name ? -1 : a.state.name > b.state.name ? 1 : 0));
    for (const { state, scene } of wanting.slice(most)) {
        state.mapAllowed = false;
        state.light.castShadow = false;
        scene.say(`light "${state.name}" gets no realtime shadow: the browser's shaders read ${units} textures at most`);
    }
}
