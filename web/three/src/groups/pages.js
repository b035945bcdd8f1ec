// Lightmap pages of a bake with light groups: what each is added up of, and the sum by the processor, as composeGroups() in
// include/halflight/render/compose.h. webgl/compose.js and webgpu/compose.js add on the device.
import { packRgb9e5 } from '../file/images.js';

/** Of a draw that also reads directions: each source has two textures, and WebGL's fragment shaders 16. */
export const SOURCES_A_DRAW = 8;

/** Half of what the target's half floats hold: filters and sums of rounded numbers stay below 65504. */
const MOST_OF_TARGET = 32752;

/** CIE luminance of linear Rec. 709, as in include/halflight/base/math.h. */
const LUMINANCE = [0.2126, 0.7152, 0.0722];

/**
 * Light by itself: the rest first, whose weight is 1, then the groups.
 * @typedef {{unitLux: number, peak: number, lightmaps: (import('../file/read.js').Pixels | null)[], directions: (import('../file/read.js').Pixels | null)[]}} LightSource
 */

/** @param {import('../file/read.js').BakedData} data @returns {LightSource[]} */
export function sourcesOf({ unitLux, lightmaps, directions, groups }) {
    const rest = { unitLux, peak: 0, lightmaps, directions };
    return [rest, ...groups].map((source) => ({ ...source, peak: source.peak || peakOf(source.lightmaps) * source.unitLux })); // a group may lack its own
}

/** @param {number[][]} weights of the groups @returns {number[][]} of the sources */
export const weightsOf = (weights) => [[1, 1, 1], ...weights];

/** The largest channel of RGB9E5 pages. */
export function peakOf(pages) {
    let peak = 0;
    for (const { data } of pages.filter(Boolean))
        for (const texel of data) {
            const mantissa = Math.max(texel & 511, (texel >>> 9) & 511, (texel >>> 18) & 511);
            peak = Math.max(peak, mantissa * 2 ** ((texel >>> 27) - 24));
        }
    return peak;
}

/** Lux of a texel of 1, a power of two, so that no sum leaves the target. @param {LightSource[]} sources @param {number[][]} weights of them */
export function unitOf(sources, weights) {
    const most = sources.reduce((sum, { peak }, i) => sum + peak * Math.max(...weights[i]), 0);
    return most > 0 ? 2 ** Math.ceil(Math.log2(most / MOST_OF_TARGET)) : 1;
}

/** Layer of each page in a texture of the pages that are there, -1 none. @param {any[]} pages */
export function layersOf(pages) {
    let layer = 0;
    return pages.map((page) => (page ? layer++ : -1));
}

/**
 * Draws that add a page up, each of a few sources. The first of a page has the rest.
 * @param {LightSource[]} sources @param {'lightmaps' | 'directions'} kind of texture that a source must have
 * @returns {{page: number, isFirst: boolean, sources: {source: number, layer: number, directionLayer: number}[]}[]}
 */
export function planDraws(sources, kind) {
    const layers = sources.map(({ lightmaps }) => layersOf(lightmaps));
    const directionLayers = sources.map(({ directions }) => layersOf(directions));
    const draws = [];
    for (let page = 0; page < sources[0].lightmaps.length; ++page) {
        const there = sources.map((_, source) => ({ source, layer: layers[source][page], directionLayer: directionLayers[source][page] ?? -1 })).filter(({ layer, directionLayer }) => layer >= 0 && (kind === 'lightmaps' || directionLayer >= 0));
        for (let i = 0; i < there.length; i += SOURCES_A_DRAW) draws.push({ page, isFirst: i === 0, sources: there.slice(i, i + SOURCES_A_DRAW) });
    }
    return draws;
}

/** By exponent of an RGB9E5 texel: what a step of its mantissae stands for. */
export const STEPS = Float64Array.from({ length: 32 }, (_, exponent) => 2 ** (exponent - 24));

/** Adds texels of a source's page, from `begin` to `end`, to sums of three numbers a texel. */
function addTexels({ lightmaps, directions, unitLux }, weight, page, light, moments, begin, end) {
    const texels = lightmaps[page].data;
    const towards = directions[page]?.data;
    for (let i = begin, at = 0; i < end; ++i, at += 3) {
        const texel = texels[i];
        const step = STEPS[texel >>> 27] * unitLux;
        const r = (texel & 511) * step * weight[0];
        const g = ((texel >>> 9) & 511) * step * weight[1];
        const b = ((texel >>> 18) & 511) * step * weight[2];
        light[at] += r;
        light[at + 1] += g;
        light[at + 2] += b;
        if (!towards) continue;
        const all = LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b;
        for (let c = 0; c < 3; ++c) moments[at + c] += all * ((towards[4 * i + c] / 255) * 2 - 1);
    }
}

/** Writes sums to a page, from texel `begin` on. */
function storeTexels(light, moments, unitLux, begin, count, lightmap, directions) {
    for (let i = 0, at = 0; i < count; ++i, at += 3) {
        lightmap[begin + i] = packRgb9e5(light[at] / unitLux, light[at + 1] / unitLux, light[at + 2] / unitLux);
        if (!directions) continue;
        const all = LUMINANCE[0] * light[at] + LUMINANCE[1] * light[at + 1] + LUMINANCE[2] * light[at + 2];
        for (let c = 0; c < 3; ++c) {
            const encoded = all > 0 ? (moments[at + c] / all) * 0.5 + 0.5 : 0.5;
            directions[4 * (begin + i) + c] = Math.floor(Math.min(Math.max(encoded, 0), 1) * 255 + 0.5);
        }
    }
}

/**
 * Adds a state up piece by piece: each step of the generator has done `most` texels, and the last one has the result.
 * @param {import('../file/read.js').BakedData} data @param {number[][]} weights of the groups @param {number} most texels
 * @returns {Generator<void, {unitLux: number, lightmaps: import('../file/read.js').Pixels[], directions: import('../file/read.js').Pixels[]}>}
 */
export function* composing(data, weights, most) {
    const sources = sourcesOf(data);
    const all = weightsOf(weights);
    const unitLux = unitOf(sources, all);
    const lightmaps = data.lightmaps.map((page) => ({ ...page, data: new Uint32Array(page.data.length) }));
    const directions = data.directions.map((page) => ({ ...page, data: page.data.slice() })); // alpha stays
    const light = new Float64Array(3 * most);
    const moments = new Float64Array(3 * most);
    for (const [page, { data: texels }] of lightmaps.entries())
        for (let begin = 0; begin < texels.length; begin += most) {
            const end = Math.min(begin + most, texels.length);
            light.fill(0);
            moments.fill(0);
            sources.forEach((source, i) => source.lightmaps[page] && addTexels(source, all[i], page, light, moments, begin, end));
            storeTexels(light, moments, unitLux, begin, end - begin, texels, directions[page]?.data);
            yield;
        }
    return { unitLux, lightmaps, directions };
}

/**
 * Pages of a state of a bake, by the processor. @param {import('../file/read.js').BakedData} data
 * @param {number[][]} [weights] of the groups in their order; the saved ones where absent
 */
export function composeLight(data, weights = data.groups.map(({ weight }) => weight)) {
    const steps = composing(data, weights, 65536);
    for (;;) {
        const { done, value } = steps.next();
        if (done) return value;
    }
}
