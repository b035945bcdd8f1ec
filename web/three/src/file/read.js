// A baked file's JSON and accessors as plain data: no three.js here. docs/format.md says what each property means.
import { reflectionTileHeight } from '../generated/shading.js';
import { readCells } from '../probes/cells.js';
import { readSight } from '../probes/sight.js';
import { bakeValueRanges } from '../generated/ranges.js';
import { checkBake, invalid, isWithin, rangeText } from './check.js';
import { membershipOf, readGroups, turningOf } from './groups.js';
import { hasSet, lossesOf } from './losses.js';
import { readByCurve, readRgb9e5, decodeImage } from './images.js';

const ROOT = 'HALFLIGHT_mixed_lighting';
const BAKE = `/extensions/${ROOT}`;
const NODE = 'HALFLIGHT_node';
const LIGHT = 'HALFLIGHT_light';
const MATERIAL = 'HALFLIGHT_material';

/**
 * What the reader takes from a glTF file.
 * @typedef {object} Source
 * @property {any} json
 * @property {(index: number) => Promise<{array: Float64Array, itemSize: number, count: number}>} accessor
 * @property {(index: number) => Promise<ArrayBuffer | Uint8Array>} bufferView
 * @property {(uri: string) => Promise<ArrayBuffer | Uint8Array>} file of a URI relative to the document, or a data URI
 */

/** @typedef {{width: number, height: number, data: Uint32Array | Uint8Array}} Pixels */
/** @typedef {{page: number, scale: number[], offset: number[], texCoord: number, perInstance: boolean}} Placement */

/** @typedef {{pixels: Pixels, unitNits: number, rotation: number}} SkyPicture RGB9E5; a texel of 1 is unitNits cd/m2; radians about +Y */

/** @typedef {{picture: Pixels, unitNits: number, size: number}} ReflectionPicture RGB9E5: probes' tiles of a width, one below the other; a texel of 1 is unitNits cd/m2 */

/** @typedef {ReflectionPicture & {probes: {position: number[], box: number[], fade: number}[]}} ReflectionData world; box: from the cube [-1, 1]^3 */

/**
 * @typedef {object} NodeData
 * @property {boolean} isStatic
 * @property {boolean} castShadows
 * @property {boolean} receiveShadows
 * @property {Placement | null} lightmap
 * @property {'automatic' | 'single' | 'volume'} probes
 * @property {number[]} probeResolution
 */

/**
 * @typedef {object} LightData
 * @property {boolean} castShadows
 * @property {number} shadowStrength
 * @property {{depth?: number, slope?: number, normal?: number}} shadowBias
 * @property {boolean} isBaked
 * @property {'realtime' | 'mixed' | 'baked'} bakeType
 * @property {number} channel
 * @property {boolean} coloredMask its mask has a colour: three channels, of which `channel` is the first
 * @property {string} reason
 * @property {number[]} worldFromLight
 * @property {number} reach
 * @property {number} outerCone
 * @property {number} group index among the bake's groups, -1 none
 * @property {number[]} white its colour times intensity at the weight 1
 * @property {{group: number, directions: number[][]}} [turns] of a light that turns: the first direction's group, and unit vectors along which it shone in the bake
 */

/**
 * @typedef {object} ProbeData
 * @property {number} count
 * @property {Float64Array} positions world
 * @property {Float32Array} radiance nine RGB coefficients for each probe
 * @property {Float32Array} occlusion all channels of the mask layers for each probe
 * @property {Uint8Array} valid
 * @property {{origin: number[], spacing: number[], size: number[]} | null} grid
 * @property {import('../probes/cells.js').Cells | null} cells null in files of older bakes
 * @property {import('../probes/sight.js').Sight | null} [sight] null where no probe has a map
 */

/**
 * @typedef {object} BakedData
 * @property {number} version
 * @property {'baked-indirect' | 'shadowmask' | 'subtractive'} mode
 * @property {number} unitLux
 * @property {Pixels[]} lightmaps RGB9E5
 * @property {Pixels[]} directions RGBA8, none when the bake was not directional
 * @property {number} maskLayers layers of four channels that masks have
 * @property {(Pixels | null)[]} masks RGBA8, the layers of a page together; null is lit everywhere; none when no light has a channel
 * @property {{rangeTexels: number, penumbraTexels: number}[]} maskChannels
 * @property {ProbeData | null} probes
 * @property {ReflectionData | null} reflections
 * @property {{zenith: number[], horizon: number[], ground: number[], picture?: SkyPicture}} sky
 * @property {number[]} shadowColor lower limit of subtractive shadows, lux; of the rest where groups have their own
 * @property {import('./groups.js').GroupData[]} groups whose light lightmaps, directions and probes lack
 * @property {string[]} lost what a tool dropped of the bake
 * @property {Map<number, NodeData>} nodes
 * @property {Map<number, LightData>} lights
 * @property {Map<number, {castShadows: boolean, receiveShadows: boolean, group: number, white: number[]}>} materials white: emission in cd/m2
 * @property {{lightmaps: number, masks: number, directions: number, probes: number, sky: number, reflections: number, groups: number}} bytes in the file
 */

export { composeLight } from '../groups/pages.js';
export { composeReflections } from '../groups/reflections.js';

/** Members of the probes' record: attenuation by mask layer. */
const OCCLUSION = ['occlusion', 'occlusion1', 'occlusion2', 'occlusion3'];

/** @param {any} json @returns {boolean} whether the file holds a bake */
export function isBaked(json) {
    return json.extensions?.[ROOT] !== undefined;
}

/** @param {Source} source @returns {Promise<BakedData>} */
export async function readBaked(source) {
    const root = source.json.extensions?.[ROOT];
    if (root === undefined) throw new Error('the file is not baked: it has no HALFLIGHT_mixed_lighting');
    checkBake(source.json);
    const bytes = { lightmaps: 0, masks: 0, directions: 0, probes: 0, sky: 0, reflections: 0, groups: 0 };
    const decoded = async (entry, path, part, decode) => {
        const image = pictureOf(source.json, entry);
        const data = bytesOf(await (image.bufferView === undefined ? source.file(image.uri) : source.bufferView(image.bufferView)));
        bytes[part] += data.byteLength;
        try {
            return await decode(data, image.mimeType ?? '');
        } catch (error) {
            throw invalid(`${BAKE}/${path}`, error.message);
        }
    };
    const pages = (list, member, part, decode) => Promise.all((list ?? []).map((entry, page) => (entry.index === undefined ? null : decoded(entry, `${member}/${page}`, part, decode))));
    const light = ({ lightmaps, lightmapEncoding: curve }, path, part) => pages(lightmaps, `${path}lightmaps`, part, (data, mimeType) => (curve ? readByCurve(data, mimeType, curve) : readRgb9e5(data)));
    const reflectionsOf = async (record, path, part) => record ? reflectionPicture(record, root.reflectionProbes?.probes.length ?? 0, await decoded(record.picture, `${path}/picture`, part, readRgb9e5), path) : null;
    const maskLayers = root.shadowmaskLayers ?? 1;
    const { picture, ...sky } = root.sky ?? { zenith: [0, 0, 0], horizon: [0, 0, 0], ground: [0, 0, 0] };
    const [lightmaps, directions, masks, skyPixels, reflections, probes] = await Promise.all([
        light(root, '', 'lightmaps'),
        pages(root.lightmapDirections, 'lightmapDirections', 'directions', decodeImage),
        pages(root.shadowmasks, 'shadowmasks', 'masks', decodeImage),
        picture && decoded(picture, 'sky/picture', 'sky', readRgb9e5),
        reflectionsOf(root.reflectionProbes, 'reflectionProbes', 'reflections'),
        readProbes(source, root, maskLayers),
    ]);
    bytes.probes = bytesOfProbes(source.json, root.probes);
    checkPages(lightmaps, directions, masks.filter(Boolean), maskLayers > 1);
    const directionsOf = (record, path) => pages(record.lightmapDirections, `${path}lightmapDirections`, 'groups', decodeImage);
    const groups = await readGroups(root, { lightmaps: light, directions: directionsOf, floats: (index) => floatsOf(source, index), reflections: reflectionsOf }, lightmaps);
    bytes.groups += bytesOfAccessors(source.json, (root.groups ?? []).map((group) => group.radiance));
    return {
        version: root.version,
        mode: root.mode,
        unitLux: root.lightmapUnitLux ?? 1,
        lightmaps,
        directions,
        maskLayers,
        masks,
        maskChannels: readChannels(root.shadowmaskChannels, 4 * maskLayers),
        probes,
        reflections: reflections && { ...reflections, probes: reflectionPlaces(root) },
        sky: picture ? { ...sky, picture: { pixels: skyPixels, unitNits: picture.unitNits, rotation: picture.rotation } } : sky,
        shadowColor: root.subtractiveShadowColor ?? [0, 0, 0],
        nodes: collect(source.json.nodes, NODE, (e, node) => nodeData(e, hasSet(source.json, node, e.lightmap?.texCoord ?? 1))),
        groups: root.shadowColorFromBake === true ? groups : groups.map((group) => ({ ...group, shadowColor: [0, 0, 0] })), // the author's stays
        lost: lossesOf(source.json),
        lights: collect(source.json.nodes, LIGHT, (e) => ({ ...lightData(e), ...membershipOf(e.baking, root), ...turningOf(e.baking, root) })),
        materials: collect(source.json.materials, MATERIAL, (e) => ({
            castShadows: e.castShadows ?? true,
            receiveShadows: e.receiveShadows ?? true,
            ...membershipOf(e.baking, root),
        })),
        bytes,
    };
}

function reflectionPicture({ unitNits, size }, probes, picture, path) {
    const height = probes * reflectionTileHeight(size);
    if (picture.width !== size || picture.height !== height)
        throw invalid(`${BAKE}/${path}/picture`, `is ${picture.width} x ${picture.height} texels, not ${size} x ${height}, as its probes' tiles`);
    return { picture, unitNits, size };
}

/** Where reflection probes are, in the world. */
function reflectionPlaces({ reflectionProbes, origin = [0, 0, 0] }) {
    const moved = (p) => p.map((x, axis) => x + origin[axis]);
    return reflectionProbes.probes.map(({ position, box, fade }) => ({ position: moved(position), box: [...box.slice(0, 12), ...moved(box.slice(12, 15)), 1], fade }));
}

/** The image of a page's texture. */
function pictureOf(json, entry) {
    const texture = json.textures[entry.index];
    const { HALFLIGHT_texture_ktx2: ktx2, EXT_texture_webp: webp } = texture.extensions ?? {};
    return json.images[(ktx2 ?? webp ?? texture).source];
}

/** @param {boolean} layered whether masks that are lit everywhere may be missing */
function checkPages(lightmaps, directions, masks, layered) {
    const first = lightmaps[0];
    for (const [name, pages] of Object.entries({ lightmap: lightmaps, direction: directions, shadowmask: masks })) {
        if (pages.length > 0 && pages.length < lightmaps.length && !(layered && pages === masks))
            throw invalid(BAKE, `has ${pages.length} ${name}s for ${lightmaps.length} lightmaps`);
        for (const page of pages) {
            if (page.width !== (pages[0] ?? first).width || page.height !== (pages[0] ?? first).height)
                throw invalid(BAKE, `its ${name} pages differ in size`);
        }
    }
}

function readChannels(channels, count) {
    return Array.from({ length: count }, (_, c) => {
        const channel = channels?.[c];
        if (channel?.encoding !== 'distance') return { rangeTexels: 0, penumbraTexels: 0 };
        return { rangeTexels: channel.rangeTexels, penumbraTexels: channel.penumbraTexels };
    });
}

async function floatsOf(source, index) {
    const { array, itemSize } = await source.accessor(index);
    const bad = array.findIndex((x) => !Number.isFinite(x));
    if (bad >= 0) throw invalid(`/accessors/${index}`, `element ${Math.floor(bad / itemSize)} holds a number that is not finite`);
    return Float32Array.from(array);
}

async function readProbes(source, root, maskLayers) {
    const p = root.probes;
    if (!p || !(p.count > 0)) return null;
    const floats = (index) => floatsOf(source, index);
    const integers = async (index) => (index === undefined ? null : (await source.accessor(index)).array);
    const [positions, radiance, occlusion, valid, tetrahedra, neighbors, sightRanges, sight] = await Promise.all([
        floats(p.positions),
        floats(p.radiance),
        Promise.all(OCCLUSION.slice(0, maskLayers).map((name) => (p[name] === undefined ? new Float32Array(4 * p.count).fill(1) : floats(p[name])))),
        source.accessor(p.valid).then((a) => Uint8Array.from(a.array)),
        integers(p.tetrahedra),
        integers(p.neighbors),
        p.sightRanges === undefined ? null : floats(p.sightRanges),
        integers(p.sight),
    ]);
    const ranged = { positions: [positions, 3, 'a position'], radiance: [radiance, 27, 'radiance'], sightRanges: [sightRanges ?? [], 1, 'a sight range'] };
    for (const [name, [values, size, what]] of Object.entries(ranged)) checkValues(name, values, size, what);
    occlusion.forEach((layer) => checkValues('occlusion', layer, 4, 'occlusion'));
    const origin = root.origin ?? [0, 0, 0];
    const places = Float64Array.from(positions, (x, i) => x + origin[i % 3]); // floats would move probes far from the origin
    const grid = p.grid ? { ...p.grid, origin: p.grid.origin.map((x, axis) => x + origin[axis]) } : null;
    const cells = tetrahedra ? readCells(tetrahedra, neighbors, valid) : null;
    return { count: p.count, positions: places, radiance, occlusion: interleave(occlusion), valid, grid, cells, sight: readSight(sightRanges, sight) };
}

/** The layers' four channels of each probe one after another. @param {Float32Array[]} layers */
function interleave(layers) {
    if (layers.length === 1) return layers[0];
    const all = new Float32Array(layers.length * layers[0].length);
    layers.forEach((layer, k) => layer.forEach((value, i) => { all[4 * (Math.floor(i / 4) * layers.length + k) + (i % 4)] = value; }));
    return all;
}

function checkValues(name, values, size, what) {
    const range = bakeValueRanges.find(([path]) => path.endsWith(`/probes/${name}`)).slice(1);
    for (let i = 0; i < values.length; ++i)
        if (!isWithin(values[i], range)) throw invalid(`${BAKE}/probes`, `probe ${Math.floor(i / size)} has ${what} that is not ${rangeText(range)}`);
}

function bytesOfProbes(json, probes = {}) {
    return bytesOfAccessors(json, ['positions', 'radiance', ...OCCLUSION, 'valid', 'tetrahedra', 'neighbors', 'sightRanges', 'sight'].map((name) => probes[name]));
}

/** In the file: of buffer views with meshopt compression the compressed ones. */
function bytesOfAccessors(json, indices) {
    const views = new Set(indices.map((index) => json.accessors?.[index]?.bufferView).filter((view) => view !== undefined));
    const stored = (view) => (view.extensions?.EXT_meshopt_compression ?? view.extensions?.KHR_meshopt_compression ?? view).byteLength;
    return [...views].reduce((sum, index) => sum + stored(json.bufferViews[index]), 0);
}

function collect(list, extension, convert) {
    const result = new Map();
    (list ?? []).forEach((entry, index) => {
        const e = entry.extensions?.[extension];
        if (e) result.set(index, convert(e, entry));
    });
    return result;
}

/** @param {boolean} hasCoordinates without which probes light it */
function nodeData(e, hasCoordinates) {
    const l = hasCoordinates ? e.lightmap : undefined;
    const lightmap = l && {
        page: l.page ?? 0,
        scale: l.scale ?? [1, 1],
        offset: l.offset ?? [0, 0],
        texCoord: l.texCoord ?? 1,
        perInstance: l.perInstance ?? false,
    };
    return {
        isStatic: e.static ?? false,
        castShadows: e.castShadows ?? true,
        receiveShadows: e.receiveShadows ?? true,
        lightmap: lightmap ?? null,
        probes: e.probes ?? 'automatic',
        probeResolution: e.probeResolution ?? [0, 0, 0],
    };
}

function lightData(e) {
    const b = e.baking;
    return {
        castShadows: e.castShadows ?? true,
        shadowStrength: e.shadowStrength ?? 1,
        shadowBias: e.shadowBias ?? {},
        isBaked: b !== undefined,
        bakeType: b?.bakeType ?? 'realtime',
        channel: b?.occlusionMaskChannel ?? -1,
        coloredMask: b?.coloredMask ?? false,
        reason: b?.reason ?? '',
        worldFromLight: b?.worldFromLight ?? [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
        reach: b?.reach ?? 0,
        outerCone: b?.outerConeAngle ?? Math.PI / 2,
    };
}

/** @param {ArrayBuffer | ArrayBufferView} data */
function bytesOf(data) {
    if (data instanceof ArrayBuffer) return new Uint8Array(data);
    return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
}
