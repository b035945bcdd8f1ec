// Light groups of a file, as plain data: docs/format.md, "Light groups".
import { bakeValueRanges } from '../generated/ranges.js';
import { invalid, isWithin, rangeText } from './check.js';

const GROUPS = '/extensions/HALFLIGHT_mixed_lighting/groups';

/** @typedef {import('./read.js').Pixels} Pixels */

/**
 * Light by itself, at the weight 1.
 * @typedef {object} GroupData
 * @property {string} name
 * @property {number[]} weight that the file saves, by channel
 * @property {number} peak lux of the brightest channel of a texel
 * @property {boolean} sky whether the sky is a member
 * @property {number[]} shadowColor lower limit of subtractive shadows, lux
 * @property {number} unitLux
 * @property {(Pixels | null)[]} lightmaps RGB9E5; null is a page without light
 * @property {(Pixels | null)[]} directions RGBA8; none where no page has them
 * @property {Float32Array} radiance nine RGB coefficients for each probe
 * @property {import('./read.js').ReflectionPicture | null} reflections null where the bake's picture has the group at its saved weight
 */

/**
 * @param {any} root extension of the file, checked
 * @param {{lightmaps: (record: any, path: string, part: string) => Promise<(Pixels | null)[]>,
 *     directions: (record: any, path: string) => Promise<(Pixels | null)[]>, floats: (index: number) => Promise<Float32Array>,
 *     reflections: (record: any, path: string, part: string) => Promise<import('./read.js').ReflectionPicture | null>}} read
 * @param {{width: number, height: number}[]} pages of the bake's own lightmap
 * @returns {Promise<GroupData[]>}
 */
export async function readGroups(root, read, pages) {
    return Promise.all(
        (root.groups ?? []).map(async (record, g) => {
            const [lightmaps, directions, radiance, reflections] = await Promise.all([
                read.lightmaps(record, `groups/${g}/`, 'groups'),
                read.directions(record, `groups/${g}/`),
                record.radiance === undefined ? new Float32Array(0) : read.floats(record.radiance),
                read.reflections(record.reflections, `groups/${g}/reflections`, 'groups'),
            ]);
            for (const list of [lightmaps, directions]) checkSizes(list, pages, `${GROUPS}/${g}`);
            checkRadiance(radiance, `${GROUPS}/${g}`);
            const { name, weight, peak = 0, sky = false, shadowColor = [0, 0, 0], lightmapUnitLux: unitLux = 1 } = record;
            return { name, weight, peak, sky, shadowColor, unitLux, lightmaps, directions, radiance, reflections };
        })
    );
}

function checkSizes(list, pages, path) {
    list.forEach((page, i) => {
        if (page && (page.width !== pages[i].width || page.height !== pages[i].height)) throw invalid(path, `has a page ${i} of another size than the bake's own`);
    });
}

function checkRadiance(values, path) {
    const range = bakeValueRanges.find(([name]) => name.endsWith('/groups/*/radiance')).slice(1);
    if (!values.every((x) => isWithin(x, range))) throw invalid(path, `has radiance that is not ${rangeText(range)} cd/m2`);
}

/** What a light or a material says of its group. @param {any} [baking] its record @param {any} root extension */
export function membershipOf(baking, root) {
    return root.groups && baking?.group !== undefined ? { group: baking.group, white: baking.white ?? [0, 0, 0] } : { group: -1, white: [0, 0, 0] };
}

/** Of a light that turns: the groups of its directions. @param {any} [baking] its record @param {any} root extension */
export function turningOf(baking, root) {
    return root.groups && baking?.turns ? { turns: baking.turns, white: baking.white ?? [0, 0, 0] } : {};
}
