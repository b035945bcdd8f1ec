// The sky at weights of light groups, as composedSky() in include/halflight/render/compose.h.

/** Colours of a gradient. Those of a sky that changes are groups of their own, "sky.zenith" and so on. */
const COLORS = ['zenith', 'horizon', 'ground'];

/** The colour that a group of that name is, or undefined. @param {string} name */
const partOf = (name) => COLORS.find((color) => name === `sky.${color}`);

const map = (sky, change) => Object.fromEntries(COLORS.map((color) => [color, sky[color].map(change)]));

/** Light over that which the file saves; 0 in a channel in which it is black. */
const factorOf = (saved, weight) => saved.map((x, c) => (x > 0 ? weight[c] / x : 0));

/** A gradient of the saved weight `saved` at another one: skyAtWeight() in src/scene/model/light_groups.cpp. */
function gradientAtWeight(sky, saved, weight) {
    const factor = factorOf(saved, weight);
    const brightest = Math.max(...COLORS.flatMap((color) => sky[color]));
    const isDark = !(brightest > 0) && saved.some((x) => x !== 0); // it stays so where other members are lit
    const white = sky.picture || isDark ? 0 : brightest > 0 ? brightest : 1; // cd/m2
    return map(sky, (x, c) => (saved[c] > 0 ? x * factor[c] : white * weight[c]));
}

/**
 * @param {{zenith: number[], horizon: number[], ground: number[], picture?: any}} saved cd/m2
 * @param {import('../file/groups.js').GroupData[]} groups @param {number[][]} weights of them
 * @returns {{gradient: {zenith: number[], horizon: number[], ground: number[]}, factor: number[]}} factor: of a picture
 */
export function composedSky(saved, groups, weights) {
    const gradient = map(saved, (x) => x);
    for (const [g, { name, weight, sky }] of groups.entries()) {
        if (!sky || weight.every((x, c) => x === weights[g][c])) continue;
        const part = partOf(name);
        if (!part) return { gradient: gradientAtWeight(saved, weight, weights[g]), factor: factorOf(weight, weights[g]) };
        gradient[part] = weights[g]; // radiance, cd/m2
    }
    return { gradient, factor: [1, 1, 1] };
}
