// The picture of reflection probes at weights of light groups, as composedReflections() in
// src/render/frame/compose_reflections.cpp.
import { packRgb9e5 } from '../file/images.js';
import { kReflectionLevels, reflectionLevelSize, reflectionTileHeight } from '../generated/shading.js';
import { peakOf, STEPS } from './pages.js';

/** The largest value of RGB9E5. */
const MOST = 65408;

/**
 * Pictures that are added up: the bake's own, then those of the groups; null of a group that the bake's own has.
 * @param {import('../file/read.js').BakedData} data
 */
export function reflectionSources({ reflections, groups }) {
    return [reflections, ...groups.map((group) => group.reflections)].map((own) => own && { ...own, peak: peakOf([own.picture]) * own.unitNits });
}

/** First texel of a level's map in a picture: level 0 at the top of a probe's tile, the others below it, side by side. */
function cornerOf(size, probe, level) {
    let left = 0;
    for (let other = 1; other < level; ++other) left += reflectionLevelSize(size, other);
    return [left, probe * reflectionTileHeight(size) + (level === 0 ? 0 : size)];
}

/** Numbers of a texel of RGB9E5, times a share and a colour, to three sums. */
function addTexel(texel, share, color, sums, at) {
    const step = STEPS[texel >>> 27] * share;
    sums[at] += (texel & 511) * step * color[0];
    sums[at + 1] += ((texel >>> 9) & 511) * step * color[1];
    sums[at + 2] += ((texel >>> 18) & 511) * step * color[2];
}

/** Where texel i of a map as wide as `width` is in one as wide as `own`: texel i covers i to i + 1. Both have a border of one texel. */
const placeOf = (i, width, own) => 1 + (i - 0.5) * ((own - 2) / (width - 2)) - 0.5;

/** Adds row `y` of a level's map, bilinearly, from a picture whose tiles have another width. @param {Float64Array} between sums of a row of it */
function addRow({ picture, size }, color, { probe, level, width, y }, sums, between) {
    const own = reflectionLevelSize(size, level);
    const [left, top] = cornerOf(size, probe, level);
    const place = placeOf(y, width, own);
    const row = Math.floor(place);
    between.fill(0, 0, 3 * own);
    for (const [dy, share] of [[0, 1 - (place - row)], [1, place - row]]) {
        const begin = (top + row + dy) * size + left;
        for (let x = 0; x < own; ++x) addTexel(picture.data[begin + x], share, color, between, 3 * x);
    }
    for (let x = 0; x < width; ++x) {
        const at = placeOf(x, width, own);
        const column = Math.floor(at);
        const share = at - column;
        const from = 3 * column;
        sums[3 * x] += between[from] * (1 - share) + between[from + 3] * share;
        sums[3 * x + 1] += between[from + 1] * (1 - share) + between[from + 4] * share;
        sums[3 * x + 2] += between[from + 2] * (1 - share) + between[from + 5] * share;
    }
}

/**
 * Adds a state up piece by piece: each step of the generator has done `most` texels, and the last one has the result.
 * @param {ReturnType<typeof reflectionSources>} sources @param {number[][]} weights of the groups @param {number} most texels
 * @returns {Generator<void, {unitNits: number, texels: Uint32Array}>}
 */
export function* composingReflections(sources, weights, most) {
    const [rest] = sources;
    const { picture, size } = rest;
    const shining = sources.flatMap((source, i) => (i > 0 && source && Math.max(...weights[i - 1]) > 0 ? [{ source, weight: weights[i - 1] }] : []));
    const brightest = shining.reduce((sum, { source, weight }) => sum + source.peak * Math.max(...weight), rest.peak);
    const unitNits = brightest > 0 ? 2 ** Math.ceil(Math.log2(brightest / MOST)) : 1;
    const own = Array(3).fill(rest.unitNits / unitNits);
    const colors = shining.map(({ source, weight }) => weight.map((x) => (x * source.unitNits) / unitNits));
    const texels = new Uint32Array(picture.data.length);
    const sums = new Float64Array(3 * size);
    const between = new Float64Array(3 * (Math.max(size, ...shining.map(({ source }) => source.size)) + 1)); // and the texel beyond, of share 0
    let done = 0;
    for (let probe = 0; probe < picture.height / reflectionTileHeight(size); ++probe)
        for (let level = 0; level < kReflectionLevels; ++level) {
            const width = reflectionLevelSize(size, level);
            const [left, top] = cornerOf(size, probe, level);
            for (let y = 0; y < width; ++y) {
                const begin = (top + y) * size + left;
                sums.fill(0, 0, 3 * width);
                for (let x = 0; x < width; ++x) addTexel(picture.data[begin + x], 1, own, sums, 3 * x);
                shining.forEach(({ source }, i) => addRow(source, colors[i], { probe, level, width, y }, sums, between));
                for (let x = 0; x < width; ++x) texels[begin + x] = packRgb9e5(sums[3 * x], sums[3 * x + 1], sums[3 * x + 2]);
                done += width;
                if (done < most) continue;
                done = 0;
                yield;
            }
        }
    return { unitNits, texels };
}

/**
 * The picture of a state of a bake. @param {import('../file/read.js').BakedData} data
 * @param {number[][]} [weights] of the groups in their order; the saved ones where absent
 * @returns {import('../file/read.js').ReflectionPicture | null}
 */
export function composeReflections(data, weights = data.groups.map(({ weight }) => weight)) {
    if (!data.reflections) return null;
    const { picture, size } = data.reflections;
    const { unitNits, texels } = composingReflections(reflectionSources(data), weights, Infinity).next().value;
    return { picture: { ...picture, data: texels }, unitNits, size };
}
