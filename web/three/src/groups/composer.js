// Pages of a bake with light groups as textures that hold a state: added up by the device, or piece by piece by the processor
// where the browser draws into no half floats. Frames in which no weight changes do nothing.
import { hasFloatTargets } from '../file/images.js';
import { arrayTexture, FORMATS } from '../scene/textures.js';
import { Pieces } from './pieces.js';
import { composeLight, composing, sourcesOf, unitOf, weightsOf } from './pages.js';

/** Texels that the processor adds up in a frame: of five sources with directions about 5 ms of one core of a server. */
export const TEXELS_A_FRAME = 16384;

/** @param {import('../file/read.js').BakedData} data @param {any} Draws of a renderer; null where there is nothing to add up */
export function makeComposer(data, Draws) {
    if (data.groups.length === 0 || data.lightmaps.length === 0) return null;
    return hasFloatTargets() ? new DevicePages(data, Draws) : new ProcessorPages(data);
}

class DevicePages {
    constructor(data, Draws) {
        this.sources = sourcesOf(data);
        this.draws = new Draws(data, this.sources);
        this.lightmaps = this.draws.lightmaps;
        this.directions = this.draws.directions;
        this.unitLux = 1;
        /** Version of the weights that each renderer's textures have. */
        this.versions = new WeakMap();
    }

    /** @param {any} renderer @param {import('./weights.js').LightGroups} groups @returns {boolean} whether the pages have all weights */
    compose(renderer, groups) {
        const device = this.draws.deviceOf(renderer);
        if (!device) return false;
        if (this.versions.get(device) === groups.version) return true;
        const weights = weightsOf(groups.weights());
        this.unitLux = unitOf(this.sources, weights);
        this.draws.draw(renderer, this.sources.map(({ unitLux }, i) => weights[i].map((x) => (x * unitLux) / this.unitLux)));
        this.versions.set(device, groups.version);
        return true;
    }

    dispose() {
        this.draws.dispose();
    }
}

class ProcessorPages {
    constructor(data) {
        this.data = data;
        const { unitLux, lightmaps, directions } = composeLight(data);
        this.lightmaps = arrayTexture(lightmaps, FORMATS.rgb9e5);
        this.directions = directions.length > 0 ? arrayTexture(directions, FORMATS.rgba8) : null;
        this.unitLux = unitLux;
        this.pieces = null;
    }

    /** @param {any} _renderer @param {import('./weights.js').LightGroups} groups @returns {boolean} whether the pages have all weights */
    compose(_renderer, groups) {
        this.pieces ??= new Pieces(() => composing(this.data, groups.weights(), TEXELS_A_FRAME));
        const value = this.pieces.next(groups.version);
        if (!value) return this.pieces.has(groups.version);
        this.unitLux = value.unitLux;
        for (const [texture, pages] of [[this.lightmaps, value.lightmaps], [this.directions, value.directions]]) {
            pages.forEach(({ data }, i) => texture.image.data.set(data, i * data.length));
            if (texture) texture.needsUpdate = true;
        }
        return this.pieces.has(groups.version);
    }

    dispose() {
        this.lightmaps.dispose();
        this.directions?.dispose();
    }
}
