// Whether a file's JSON is one that the program reads: the same paths, the same sentences. Types and ranges of numbers are
// tables; what members refer to is here.
import { bakeRanges } from '../generated/ranges.js';
import { bakeTypes } from './types.js';

const BAKE = '/extensions/HALFLIGHT_mixed_lighting';
const LARGEST_FLOAT = 3.4028234663852886e38;
const LARGEST_INDEX = 2 ** 31 - 1;
const MODES = ['baked-indirect', 'shadowmask', 'subtractive'];
const PROBES = ['automatic', 'single', 'volume'];
const MOST_REFLECTIONS = 32;
const MOST_GROUPS = 16;
const MOST_DIRECTIONS = 12;

/** @param {string} path @param {string} message */
export function invalid(path, message) {
    return new Error(`${path}: ${message}`);
}

/** JSON text of a value, short enough for a sentence. */
function shown(value) {
    if (Array.isArray(value)) return value.length === 0 ? 'an empty array' : 'an array';
    if (value !== null && typeof value === 'object') return 'an object';
    const text = JSON.stringify(value) ?? String(value);
    return text.length <= 40 ? text : `${text.slice(0, 40)}...`;
}

const isIndex = (x) => Number.isInteger(x) && x >= 0 && x <= LARGEST_INDEX;
const isFloat = (x) => typeof x === 'number' && Math.abs(x) <= LARGEST_FLOAT;
const isObject = (x) => x !== null && typeof x === 'object' && !Array.isArray(x);
const isList = (x, count, test) => Array.isArray(x) && (!count || x.length === count) && x.every(test);

/** Tests of the types, and what a value should be. @type {Record<string, [(x: any, count?: number) => boolean, (count?: number) => string]>} */
const KINDS = {
    Any: [() => true, () => ''],
    Object: [isObject, () => 'an object'],
    Array: [Array.isArray, () => 'an array'],
    Text: [(x) => typeof x === 'string', () => 'a string'],
    Flag: [(x) => typeof x === 'boolean', () => 'true or false'],
    Number: [isFloat, () => 'a number that fits a float'],
    Index: [isIndex, () => 'an unsigned integer below 2^31'],
    Length: [(x) => Number.isSafeInteger(x) && x >= 0, () => 'an unsigned integer'],
    Signed: [Number.isInteger, () => 'an integer'],
    Indices: [(x, count) => isList(x, count, isIndex), (count) => `an array of ${count} unsigned integers`],
    Numbers: [(x, count) => isList(x, count, isFloat), (count) => `an array of ${count ? `${count} ` : ''}numbers that fit floats`],
};

/** The tables as a tree: an item stands for the items of an array or the members of an object. */
function makeShape() {
    const top = { kind: 'Object', members: {} };
    const at = (path) => {
        let shape = top;
        for (const step of path.split('/')) {
            shape.kind = step === '*' ? 'Array' : 'Object';
            if (step === '*') shape = shape.items ??= { kind: 'Any', members: {} };
            else shape = shape.members[step] ??= { kind: 'Any', members: {} };
        }
        return shape;
    };
    for (const [path, kind, count] of bakeTypes) Object.assign(at(path), { kind, count });
    for (const [path, ...range] of bakeRanges) at(path).range = range;
    return top;
}

const SHAPE = makeShape();

export function isWithin(x, [least, most, above]) {
    return (above ? x > least : x >= least) && x <= most;
}

export function rangeText([least, most, above]) {
    return above ? `above ${least}, at most ${most}` : `from ${least} to ${most}`;
}

function checkShape(value, shape, path) {
    const [test, wanted] = KINDS[shape.kind];
    if (!test(value, shape.count)) throw invalid(path, `is ${shown(value)}, not ${wanted(shape.count)}`);
    if (shape.range)
        [value].flat().forEach((x, i) => {
            if (!isWithin(x, shape.range)) throw invalid(Array.isArray(value) ? `${path}/${i}` : path, `is ${shown(x)}, not a number ${rangeText(shape.range)}`);
        });
    if (shape.items) value.forEach((item, i) => checkShape(item, shape.items, `${path}/${i}`));
    for (const [name, member] of Object.entries(shape.members)) if (value[name] !== undefined) checkShape(value[name], member, `${path}/${name}`);
}

/** Throws one sentence, with a path, where the program refuses the file too. @param {any} json of a file with a bake */
export function checkBake(json) {
    const root = json.extensions.HALFLIGHT_mixed_lighting;
    checkShape(root, SHAPE.members.extensions.members.HALFLIGHT_mixed_lighting, BAKE);
    if (root.version > 3) throw invalid(BAKE, `was written by a newer version of this program: its format is version ${root.version}`);
    if (root.version === 1) throw invalid(BAKE, 'was written by an old version of the program: bake again');
    if (root.version !== 2 && root.version !== 3) throw invalid(BAKE, `version is ${shown(root.version)}, not 2 or 3`);
    if (!MODES.includes(root.mode)) throw invalid(BAKE, `mode is not ${MODES.slice(0, 2).join(', ')} or ${MODES[2]}`);
    checkShape(json, SHAPE, '');
    checkBounds(json);
    checkMembers(root);
    checkLayers(json, root);
    checkPictures(json, root);
    checkReflections(json, root.reflectionProbes);
    checkProbes(json, root.probes);
    if (root.groups !== undefined) checkGroups(json, root);
    (json.nodes ?? []).forEach((node, i) => checkNode(node, root, `/nodes/${i}`));
}

/** Members of an object of the root that a reader cannot do without. */
const REQUIRED = { sky: ['zenith', 'horizon', 'ground'], 'sky/picture': ['unitNits', 'rotation'], lightmapEncoding: ['scale', 'exponent'], 'probes/grid': ['origin', 'spacing', 'size'] };

function checkMembers(root) {
    for (const [path, names] of Object.entries(REQUIRED)) {
        const object = path.split('/').reduce((value, step) => value?.[step], root);
        for (const name of object ? names : []) if (object[name] === undefined) throw invalid(`${BAKE}/${path}`, `${name} is missing`);
    }
    (root.shadowmaskChannels ?? []).forEach(({ encoding, rangeTexels, penumbraTexels }, i) => {
        if (encoding !== 'distance') return;
        if (rangeTexels === undefined || penumbraTexels === undefined) throw invalid(`${BAKE}/shadowmaskChannels/${i}`, 'rangeTexels or penumbraTexels is missing');
    });
}

/** Mask layers, of four channels each. @param {any} json @param {any} root */
function checkLayers(json, root) {
    const { shadowmaskLayers: layers, shadowmaskChannels: channels } = root;
    if (layers !== undefined && root.version < 3) throw invalid(BAKE, 'shadowmaskLayers is of version 3 of the format');
    const count = 4 * (layers ?? 1);
    if (channels !== undefined && channels.length !== count) throw invalid(`${BAKE}/shadowmaskChannels`, `is not an array of ${count}`);
    (json.nodes ?? []).forEach((node, i) => {
        const { occlusionMaskChannel: channel, coloredMask } = node.extensions?.HALFLIGHT_light?.baking ?? {};
        if (channel >= count) throw invalid(`/nodes/${i}/extensions/HALFLIGHT_light/baking/occlusionMaskChannel`, 'is of a mask layer that the file lacks');
        if (!coloredMask) return;
        const refuse = (why) => invalid(BAKE, `light "${node.name ?? i}" has a coloured mask, and ${why}`);
        if (root.version < 3) throw refuse('the version has none');
        if (!(channel >= 0) || channel % 4 !== 0) throw refuse('its channel is not the first of a mask layer');
        if (channels?.slice(channel, channel + 3).some(({ encoding }) => encoding === 'distance')) throw refuse('shadowmaskChannels says that it holds distances');
    });
}

/** Light groups, and that lights and materials name none that the file lacks. @param {any} json @param {any} root */
function checkGroups(json, root) {
    const { groups } = root;
    if (groups.length > MOST_GROUPS || root.version !== 3) throw invalid(BAKE, `groups is no list of at most ${MOST_GROUPS}, or the version has no groups`);
    groups.forEach(({ name, weight }, g) => {
        if (!name || groups.findIndex((other) => other.name === name) < g) throw invalid(`${BAKE}/groups/${g}`, 'has no name of its own');
        if (!weight) throw invalid(`${BAKE}/groups/${g}`, 'weight is not three numbers');
    });
    for (const [kind, list, extension] of [['light', json.nodes, 'HALFLIGHT_light'], ['material', json.materials, 'HALFLIGHT_material']])
        (list ?? []).forEach(({ name = '', extensions }) => {
            if (extensions?.[extension]?.baking?.group >= groups.length) throw invalid(BAKE, `${kind} "${name}" is in a light group that the file lacks`);
        });
    (json.nodes ?? []).forEach(({ name = '', extensions }) => {
        const { group, turns } = extensions?.HALFLIGHT_light?.baking ?? {};
        if (!turns) return;
        const count = turns.directions?.length ?? 0;
        const fits = turns.group !== undefined && group === undefined && count > 0 && count <= MOST_DIRECTIONS && turns.group + count <= groups.length;
        if (!fits) throw invalid(BAKE, `light "${name}" turns by light groups that the file lacks`);
        if (turns.directions.some((d) => Math.abs(Math.hypot(...d) - 1) > 1e-3)) throw invalid(BAKE, `light "${name}" turns by directions that are no unit vectors`);
    });
    groups.forEach((group, g) => checkGroup(json, root, group, `${BAKE}/groups/${g}`));
}

/** Pages and probes of a group: as many as the bake has. */
function checkGroup(json, root, group, path) {
    const { lightmaps = [], lightmapDirections = [], lightmapEncoding: curve } = group;
    const pages = root.lightmaps?.length ?? 0;
    lightmaps.forEach((entry, i) => {
        if (entry.index === undefined) return;
        checkPicture(json, entry, `${path}/lightmaps/${i}`);
        if (curve && !(curve.scale && curve.exponent)) throw invalid(`${path}/lightmaps/${i}`, 'lightmapEncoding has no scale or no exponent');
    });
    if (lightmaps.length !== pages) throw invalid(path, `has ${lightmaps.length} lightmaps beside the bake's ${pages}`);
    lightmapDirections.forEach((entry, i) => entry.index !== undefined && checkPicture(json, entry, `${path}/lightmapDirections/${i}`));
    if (lightmapDirections.length > 0 && lightmapDirections.length !== pages) throw invalid(path, `has ${lightmapDirections.length} lightmapDirections for ${pages} lightmaps`);
    if (lightmapDirections.length > 0 && !(root.lightmapDirections?.length > 0)) throw invalid(path, "has directions, which the bake's own lightmap lacks");
    const probes = root.probes?.count ?? 0;
    if (probes > 0 || group.radiance !== undefined) checkAccessor(json, group, 'radiance', path, 'VEC3', 9 * probes);
    if (group.reflections) checkReflectionPicture(json, group.reflections, `${path}/reflections`);
}

function checkPictures(json, root) {
    const lists = { lightmaps: root.lightmaps, lightmapDirections: root.lightmapDirections, shadowmasks: root.shadowmasks };
    const pages = root.lightmaps?.length ?? 0;
    for (const [name, list] of Object.entries(lists)) {
        const layers = name === 'shadowmasks' ? (root.shadowmaskLayers ?? 1) : 1;
        (list ?? []).forEach((entry, i) => {
            if (layers === 1 || entry.index !== undefined) checkPicture(json, entry, `${BAKE}/${name}/${i}`);
        });
        if (list && list.length > 0 && list.length !== pages * layers)
            throw invalid(BAKE, `has ${list.length} ${name} for ${pages} lightmaps${layers > 1 ? ` in ${layers} layers` : ''}`);
    }
    if (root.sky?.picture) checkPicture(json, root.sky.picture, `${BAKE}/sky/picture`);
}

function checkPicture(json, entry, path) {
    const texture = json.textures?.[entry.index];
    if (!texture) throw invalid(path, 'refers to a texture that does not exist');
    const { HALFLIGHT_texture_ktx2: ktx2, EXT_texture_webp: webp } = texture.extensions ?? {};
    const image = json.images?.[(ktx2 ?? webp ?? texture).source];
    if (!image) throw invalid(path, 'refers to an image that does not exist');
    if (image.bufferView === undefined && image.uri === undefined) throw invalid(path, 'has neither a buffer view nor a file');
    if (image.bufferView !== undefined && !json.bufferViews?.[image.bufferView]) throw invalid(path, 'refers to a buffer view that does not exist');
}

function checkReflections(json, reflections) {
    if (!reflections) return;
    const path = `${BAKE}/reflectionProbes`;
    checkReflectionPicture(json, reflections, path);
    const { probes } = reflections;
    if (!probes || probes.length < 1 || probes.length > MOST_REFLECTIONS) throw invalid(path, `probes is not a list of 1 to ${MOST_REFLECTIONS}`);
    probes.forEach(({ position, box, fade }, i) => {
        const own = `${path}/probes/${i}`;
        if (!position) throw invalid(own, 'position is not three numbers');
        if (!box || !(thickness(box) > 2e-7)) throw invalid(own, 'box is not a transform of 16 numbers with an inverse, or thinner than 2e-7 m');
        if (!(fade > 0)) throw invalid(own, 'fade is not a number above 0');
    });
}

/** The probes' picture, or that of a light group. */
function checkReflectionPicture(json, { picture, unitNits, size }, path) {
    if (!(unitNits > 0)) throw invalid(path, 'unitNits is not a number above 0');
    if (!(size % 16 === 0)) throw invalid(path, 'size is not a multiple of 16 from 32 to 1024');
    if (!picture) throw invalid(`${path}/picture`, 'refers to a texture that does not exist');
    checkPicture(json, picture, `${path}/picture`);
}

/** Least distance of opposite faces of the box that a matrix makes of [-1, 1]^3; 0 without an inverse. @param {number[]} m */
function thickness(m) {
    const [a, b, c] = [0, 4, 8].map((i) => m.slice(i, i + 3));
    const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const faces = [cross(b, c), cross(c, a), cross(a, b)];
    const volume = Math.abs(a[0] * faces[0][0] + a[1] * faces[0][1] + a[2] * faces[0][2]);
    return volume > 0 ? Math.min(...faces.map((face) => (2 * volume) / Math.hypot(...face))) : 0;
}

/** Components of the probes' accessors, and how many elements each has. */
const PROBE_ACCESSORS = {
    positions: ['VEC3', (n) => n], radiance: ['VEC3', (n) => 9 * n], occlusion: ['VEC4', (n) => n],
    occlusion1: ['VEC4', (n) => n], occlusion2: ['VEC4', (n) => n], occlusion3: ['VEC4', (n) => n], valid: ['SCALAR', (n) => n], sightRanges: ['SCALAR', (n) => n],
    tetrahedra: ['VEC4', null], neighbors: ['VEC4', (_, count) => count('tetrahedra')], sight: ['VEC2', null],
};
const SIZES = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };

function checkProbes(json, probes) {
    if (!probes) return;
    const path = `${BAKE}/probes`;
    if (probes.count === undefined) throw invalid(path, 'count is missing');
    const optional = ['occlusion1', 'occlusion2', 'occlusion3', 'tetrahedra', 'neighbors', 'sightRanges', 'sight'];
    const count = (name) => json.accessors?.[probes[name]]?.count;
    for (const [name, [type, wanted]] of Object.entries(PROBE_ACCESSORS)) {
        if (probes[name] === undefined && optional.includes(name)) continue;
        checkAccessor(json, probes, name, path, type, wanted?.(probes.count, count));
    }
}

/** A record's member that is an accessor. @param {number} [elements] any number where absent */
function checkAccessor(json, record, name, path, type, elements) {
    const accessor = json.accessors?.[record[name]];
    if (!accessor) throw invalid(path, `${name} refers to an accessor that does not exist`);
    if (elements !== undefined && accessor.count !== elements) throw invalid(path, `${name} does not have ${elements} elements`);
    if (accessor.type !== type && SIZES[accessor.type] !== undefined) throw invalid(`/accessors/${record[name]}`, `has ${SIZES[accessor.type]} components where ${SIZES[type]} are needed`);
}

/** Bytes of a component by its type in glTF. */
const BYTES = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };

/** Buffer views lie in their buffers, accessors in their views. Compressed views have bounds of their own. */
function checkBounds(json) {
    const { buffers = [], bufferViews: views = [], accessors = [] } = json;
    const isCompressed = ({ extensions = {} }) => extensions.EXT_meshopt_compression || extensions.KHR_meshopt_compression;
    views.forEach((view, i) => {
        if (isCompressed(view)) return;
        const path = `/bufferViews/${i}`;
        const buffer = buffers[view.buffer];
        if (!buffer) throw invalid(path, `refers to buffer ${view.buffer} of ${buffers.length}`);
        if ((view.byteOffset ?? 0) + view.byteLength > buffer.byteLength) throw invalid(path, `reaches past the end of buffer ${view.buffer}`);
    });
    accessors.forEach(({ bufferView, byteOffset = 0, componentType, count, type }, i) => {
        if (bufferView === undefined) return;
        const view = views[bufferView];
        if (!view) throw invalid(`/accessors/${i}`, `refers to buffer view ${bufferView} of ${views.length}`);
        const element = BYTES[componentType] * SIZES[type];
        if (!(element > 0)) throw invalid(`/accessors/${i}`, 'has an unknown type or component type');
        const end = byteOffset + (count - 1) * (view.byteStride ?? element) + element;
        if (!isCompressed(view) && !(end <= view.byteLength)) throw invalid(`/accessors/${i}`, 'reads past the end of its buffer view');
    });
}

function checkNode({ extensions }, root, path) {
    const node = extensions?.HALFLIGHT_node;
    const own = `${path}/extensions/HALFLIGHT_node`;
    if (node?.probes !== undefined && !PROBES.includes(node.probes)) throw invalid(own, `probes is not ${PROBES.slice(0, 2).join(', ')} or ${PROBES[2]}`);
    if (node?.lightmap && !node.lightmap.perInstance) {
        const { page, scale, offset } = node.lightmap;
        if (!(page < (root.lightmaps?.length ?? 0))) throw invalid(`${own}/lightmap`, 'refers to a lightmap page that does not exist');
        if (!scale || !offset) throw invalid(`${own}/lightmap`, 'scale and offset are not two numbers each');
    }
}
