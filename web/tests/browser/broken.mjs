// Files with one fault each: refused with the path that the program names, before anything is shown, or shown with a sentence.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { findProgram } from '../harness.mjs';
import { bakeGroups } from './groups_scene.mjs';
import { studio } from './studio.mjs';

const BAKE = '/extensions/HALFLIGHT_mixed_lighting';
const LOST = 'the file has lost part of its bake: ';

/** A baked file, with what the faults need to find. */
class Faulty {
    constructor(path) {
        Object.assign(this, readGlb(path));
        this.buffer = Buffer.from(this.buffer);
        this.bake = this.json.extensions.HALFLIGHT_mixed_lighting;
        this.probes = this.bake.probes;
    }

    accessor(name) {
        return this.json.accessors[this.probes[name]];
    }

    at(name) {
        const { bufferView, byteOffset = 0 } = this.accessor(name);
        return (this.json.bufferViews[bufferView].byteOffset ?? 0) + byteOffset;
    }

    picture({ index }) {
        const texture = this.json.textures[index];
        const held = Object.values(texture.extensions ?? {}).find((e) => e.source !== undefined) ?? texture;
        return this.json.bufferViews[this.json.images[held.source].bufferView];
    }

    /** A group that has directions, and its index. */
    group() {
        const index = this.bake.groups.findIndex(({ lightmapDirections }) => lightmapDirections?.some((page) => page.index !== undefined));
        return { index, group: this.bake.groups[index] };
    }

    floatsOf(accessor) {
        const { bufferView, byteOffset = 0 } = this.json.accessors[accessor];
        return (this.json.bufferViews[bufferView].byteOffset ?? 0) + byteOffset;
    }

    node(extension) {
        return this.json.nodes.find((node) => node.extensions?.[extension]).extensions[extension];
    }
}

const probesAre = (name, change) => (f) => { f.accessor(name).count = change(f.accessor(name).count); };
const setFloat = (name, element, value) => (f) => f.buffer.writeFloatLE(value, f.at(name) + 4 * element);
const reflection = (change) => (f) => change(f.bake.reflectionProbes);

const zeroLightmap = (f) => {
    const { byteOffset, byteLength } = f.picture(f.bake.lightmaps[0]);
    f.buffer.fill(0, byteOffset + 200, byteOffset + byteLength);
};

/** What is wrong, how, and the beginning of the sentence that refuses the file, or a part of the warning that it is shown with. */
const FAULTS = [
    ['radiance is short', probesAre('radiance', (n) => n - 1), `${BAKE}/probes: radiance does not have`],
    ['radiance is long', probesAre('radiance', (n) => 100 * n), /^\/accessors\/\d+: reads past the end/],
    ['occlusion is short', probesAre('occlusion', () => 100), `${BAKE}/probes: occlusion does not have`],
    ['tetrahedra are short', probesAre('tetrahedra', () => 100), `${BAKE}/probes: neighbors does not have 100`],
    ['sight is short', probesAre('sight', () => 5), `${BAKE}/probes: sight does not hold`],
    ['the count is another', (f) => { f.probes.count = 5; }, `${BAKE}/probes: positions does not have 5`],
    ['no such accessor', (f) => { f.probes.radiance = 999; }, `${BAKE}/probes: radiance refers to`],
    ['an accessor by name', (f) => { f.probes.radiance = 'x'; }, `${BAKE}/probes/radiance: is "x"`],
    ['an accessor of another type', (f) => { f.accessor('radiance').type = 'VEC2'; }, '/accessors/'],
    ['a vertex that is no probe', (f) => f.buffer.writeUInt32LE(4000000000, f.at('tetrahedra')), `${BAKE}/probes: tetrahedron 0 has a vertex`],
    ['a neighbour elsewhere', (f) => f.buffer.writeUInt32LE(12345678, f.at('neighbors')), `${BAKE}/probes: tetrahedron 0 has a neighbour`],
    ['a position that is not finite', setFloat('positions', 1, NaN), /^\/accessors\/\d+: element 0 holds a number that is not finite/],
    ['radiance that is not finite', setFloat('radiance', 27 * 133 + 5, NaN), /^\/accessors\/\d+: element 1198 holds/],
    ['radiance beyond light', setFloat('radiance', 30, 1e38), `${BAKE}/probes: probe 1 has radiance`],
    ['occlusion above 1', setFloat('occlusion', 9, 1.5), `${BAKE}/probes: probe 2 has occlusion`],
    ['a view beyond the buffer', (f) => { f.json.bufferViews[f.accessor('sight').bufferView].byteOffset = f.buffer.length - 8; }, '/bufferViews/'],
    ['no such lightmap', (f) => { f.bake.lightmaps = [{ index: 99 }]; }, `${BAKE}/lightmaps/0: refers to a texture`],
    ['lightmaps gone', (f) => { delete f.bake.lightmaps; }, `${BAKE}: has 1 shadowmasks for 0 lightmaps`],
    ['a lightmap cut short', (f) => { f.picture(f.bake.lightmaps[0]).byteLength = 100; }, `${BAKE}/lightmaps/0: the KTX2 image is not readable`],
    ['a mask cut short', (f) => { f.picture(f.bake.shadowmasks[0]).byteLength = 100; }, `${BAKE}/shadowmasks/0: the browser cannot decode`],
    ['reflections cut short', (f) => { f.picture(f.bake.reflectionProbes.picture).byteLength = 100; }, `${BAKE}/reflectionProbes/picture: the KTX2`],
    ['a lightmap of zeros', zeroLightmap, `${BAKE}/lightmaps/0: the KTX2`],
    ['a lightmap too wide', (f) => f.buffer.writeUInt32LE(100000, f.picture(f.bake.lightmaps[0]).byteOffset + 20), `${BAKE}/lightmaps/0: the KTX2`],
    ['a tile of no size', reflection((r) => { r.size = 0; }), `${BAKE}/reflectionProbes/size: is 0`],
    ['a box of zeros', reflection((r) => { r.probes[0].box = new Array(16).fill(0); }), `${BAKE}/reflectionProbes/probes/0: box is not`],
    ['a box too large', reflection((r) => { r.probes[0].box[0] = 1e20; }), `${BAKE}/reflectionProbes/probes/0/box/0: is`],
    ['a fade too short', reflection((r) => { r.probes[0].fade = 1e-30; }), `${BAKE}/reflectionProbes/probes/0/fade: is`],
    ['a unit beyond light', reflection((r) => { r.unitNits = 3e38; }), `${BAKE}/reflectionProbes/unitNits: is`],
    ['another mode', (f) => { f.bake.mode = 'foo'; }, `${BAKE}: mode is not`],
    ['a newer version', (f) => { f.bake.version = 99; }, `${BAKE}: was written by a newer version`],
    ['a version in words', (f) => { f.bake.version = 'two'; }, `${BAKE}/version: is "two"`],
    ['a sky in words', (f) => { f.bake.sky = 'blue'; }, `${BAKE}/sky: is "blue", not an object`],
    ['a sky without its ground', (f) => { delete f.bake.sky.ground; }, `${BAKE}/sky: ground is missing`],
    ['a sky below 0', (f) => { f.bake.sky.horizon[1] = -1; }, `${BAKE}/sky/horizon/1: is -1`],
    ['an extension that is null', (f) => { f.json.extensions.HALFLIGHT_mixed_lighting = null; }, `${BAKE}: is null`],
    ['an extension that is a list', (f) => { f.json.extensions.HALFLIGHT_mixed_lighting = []; }, `${BAKE}: is an empty array`],
    ['no such page', (f) => { f.node('HALFLIGHT_node').lightmap.page = 9; }, '/nodes/0/extensions/HALFLIGHT_node/lightmap: refers to'],
    ['a scale in words', (f) => { f.node('HALFLIGHT_node').lightmap.scale = 'a'; }, '/nodes/0/extensions/HALFLIGHT_node/lightmap/scale: is "a"'],
    ['a scale gone', (f) => { delete f.node('HALFLIGHT_node').lightmap.scale; }, '/nodes/0/extensions/HALFLIGHT_node/lightmap: scale and offset'],
    ['no such channel', (f) => { f.node('HALFLIGHT_light').baking.occlusionMaskChannel = 70; }, /^\/nodes\/\d+\/extensions\/HALFLIGHT_light\/baking\/occlusionMaskChannel: is/],
    ['a coloured mask of version 2', (f) => { f.node('HALFLIGHT_light').baking.coloredMask = true; }, `${BAKE}: light "sun" has a coloured mask, and the version has none`],
    ['a coloured mask in the second channel', (f) => { f.bake.version = 3; Object.assign(f.node('HALFLIGHT_light').baking, { coloredMask: true, occlusionMaskChannel: 1 }); },
        `${BAKE}: light "sun" has a coloured mask, and its channel is not the first`],
    ['masks gone', (f) => { delete f.bake.shadowmasks; }, `${LOST}its shadowmasks`],
    ['a set of coordinates that is not there', (f) => { f.node('HALFLIGHT_node').lightmap.texCoord = 7; }, `${LOST}the lightmap coordinates of objects "floor"`],
    ['coordinates gone', (f) => { delete f.json.meshes[0].primitives[0].attributes.TEXCOORD_1; }, `${LOST}the lightmap coordinates of objects "floor"`],
    ['the record of a light gone', (f) => { delete f.node('HALFLIGHT_light').baking; }, `${LOST}1 of 1 baked lights`],
    ['the place of a light gone', (f) => { delete f.node('HALFLIGHT_light').baking.worldFromLight; }, 'moved since its bake'],
];

const first = (change) => (f) => change(f.bake.groups[0], f);
const directed = (change) => (f) => change(f.group().group, f);

/** The same for a file with light groups. */
const GROUP_FAULTS = [
    ['a group without a name', first((g) => { delete g.name; }), `${BAKE}/groups/0: has no name of its own`],
    ['two groups of one name', first((g, f) => { f.bake.groups[1].name = g.name; }), `${BAKE}/groups/1: has no name of its own`],
    ['a group without a weight', first((g) => { delete g.weight; }), `${BAKE}/groups/0: weight is not three numbers`],
    ['a weight below 0', first((g) => { g.weight[1] = -1; }), `${BAKE}/groups/0/weight/1: is -1`],
    ['a weight in words', first((g) => { g.weight = 'red'; }), `${BAKE}/groups/0/weight: is "red"`],
    ['a peak beyond light', first((g) => { g.peak = 1e30; }), `${BAKE}/groups/0/peak: is 1e+30`],
    ['a unit of 0', first((g) => { g.lightmapUnitLux = 0; }), `${BAKE}/groups/0/lightmapUnitLux: is 0`],
    ['seventeen groups', (f) => { f.bake.groups = Array.from({ length: 17 }, (_, i) => ({ ...f.bake.groups[0], name: `group ${i}` })); }, `${BAKE}: groups is no list of at most 16`],
    ['groups in version 2', (f) => { f.bake.version = 2; }, `${BAKE}: groups is no list of at most 16, or the version has no groups`],
    ['a light in a group that is not there', (f) => { f.json.nodes.find(({ name }) => name === 'lamp').extensions.HALFLIGHT_light.baking.group = 9; }, `${BAKE}: light "lamp" is in a light group that the file lacks`],
    ['a material in a group that is not there', (f) => { f.json.materials.find(({ extensions }) => extensions?.HALFLIGHT_material?.baking).extensions.HALFLIGHT_material.baking.group = 9; }, `${BAKE}: material "neon" is in a light group that the file lacks`],
    ['a group without pages', first((g) => { delete g.lightmaps; }), `${BAKE}/groups/0: has 0 lightmaps beside the bake's`],
    ['a page that is not there', first((g) => { g.lightmaps[0] = { index: 999 }; }), `${BAKE}/groups/0/lightmaps/0: refers to a texture`],
    ['a page cut short', directed((g, f) => { f.picture(g.lightmaps.find((page) => page.index !== undefined)).byteLength = 100; }), /groups\/\d\/lightmaps\/\d: the KTX2 image is not readable/],
    ['a page of another size', directed((g, f) => { g.lightmaps[0] = f.bake.reflectionProbes.picture; }), /groups\/\d: has a page 0 of another size than the bake's own/],
    ['directions of fewer pages', directed((g) => g.lightmapDirections.pop()), /groups\/\d: has \d lightmapDirections for \d lightmaps/],
    ['directions that the bake lacks', (f) => { delete f.bake.lightmapDirections; }, /groups\/\d: has directions, which the bake's own lightmap lacks/],
    ['radiance gone', first((g) => { delete g.radiance; }), `${BAKE}/groups/0: radiance refers to an accessor`],
    ['radiance is short', first((g, f) => { f.json.accessors[g.radiance].count -= 1; }), `${BAKE}/groups/0: radiance does not have`],
    ['radiance of another type', first((g, f) => { f.json.accessors[g.radiance].type = 'VEC2'; }), /^\/accessors\/\d+: has 2 components/],
    ['radiance that is not finite', first((g, f) => f.buffer.writeFloatLE(NaN, f.floatsOf(g.radiance) + 4 * 7)), /^\/accessors\/\d+: element 2 holds/],
    ['radiance beyond light', first((g, f) => f.buffer.writeFloatLE(1e38, f.floatsOf(g.radiance) + 4 * 7)), `${BAKE}/groups/0: has radiance that is not`],
    ['a colour of shadows below 0', first((g) => { g.shadowColor = [0, -1, 0]; }), `${BAKE}/groups/0/shadowColor/1: is -1`],
    ['reflections of unit 0', first((g) => { g.reflections.unitNits = 0; }), `${BAKE}/groups/0/reflections/unitNits: is 0`],
    ['reflections without a unit', first((g) => { delete g.reflections.unitNits; }), `${BAKE}/groups/0/reflections: unitNits is not`],
    ['reflections too narrow', first((g) => { g.reflections.size = 16; }), `${BAKE}/groups/0/reflections/size: is 16`],
    ['reflections of an odd width', first((g) => { g.reflections.size = 40; }), `${BAKE}/groups/0/reflections: size is not a multiple of 16`],
    ['reflections of another size', first((g) => { g.reflections.size = 32; }), `${BAKE}/groups/0/reflections/picture: is 64 x`],
    ['reflections without a picture', first((g) => { delete g.reflections.picture; }), `${BAKE}/groups/0/reflections/picture: refers to a texture`],
    ['reflections cut short', first((g, f) => { f.picture(g.reflections.picture).byteLength = 100; }), `${BAKE}/groups/0/reflections/picture: the KTX2 image is not readable`],
    ['groups gone', (f) => { delete f.bake.groups; }, `${LOST}its groups`],
];

/** What the program says to a file: the path it refuses it with, or parts of the bake that are lost and lights that moved. */
function programsWords(path) {
    const { stderr, status } = spawnSync(findProgram(), ['info', path], { encoding: 'utf8' });
    if (status !== 0) return { path: /\.glb: (\/\S*): /.exec(stderr)?.[1] ?? stderr };
    return { warnings: [...stderr.matchAll(/lost part of its bake: (.*?)[;\n]|(moved)/g)].map(([, lost, moved]) => lost ?? moved) };
}

/** Loads a file, and draws it twice where it loads. Runs in the page. */
async function attempt(file) {
    const { loaded, load, makeRenderer, viewOf } = window.halflightPage;
    const errors = [];
    const { error, warn } = console;
    console.warn = () => {};
    console.error = (...words) => errors.push(words.join(' '));
    try {
        await load({ file });
    } catch (thrown) {
        return { refused: thrown.message };
    } finally {
        console.warn = warn;
        console.error = error;
    }
    const renderer = await makeRenderer(32, 18);
    const view = viewOf('main', 16 / 9);
    console.warn = () => {};
    console.error = (...words) => errors.push(words.join(' '));
    try {
        for (let i = 0; i < 2; ++i) {
            loaded.halflight.update(renderer, view);
            renderer.render(loaded.scene, view);
        }
    } catch (thrown) {
        errors.push(thrown.message);
    } finally {
        console.warn = warn;
        console.error = error;
    }
    return { warnings: [...loaded.halflight.warnings], errors };
}

test('broken files: refused with a path, or shown with a sentence', async () => {
    studio.bake('tests/sphere_on_floor', 'whole', '--lightmap-size', '128');
    const { page } = await studio.pageOf('three');
    assert.deepEqual(await wrongOf(page, 'whole', FAULTS), []);
    writeFileSync(join(studio.files, 'cut.glb'), Buffer.from(new Uint8Array(64)));
    const cut = await page.evaluate(attempt, '/files/cut.glb');
    assert.ok(cut.refused, 'what is no glTF is refused by the loader');
});

test('broken files: light groups S33', async () => {
    const { page } = await studio.pageOf('three');
    assert.deepEqual(await wrongOf(page, bakeGroups(), GROUP_FAULTS), []);
});

/** Sentences about faults that a file was shown with, or refused in another way than by the program. @param {string} base a file that is whole */
async function wrongOf(page, base, faults) {
    const whole = await page.evaluate(attempt, `/files/${base}.glb`);
    assert.deepEqual(whole.errors, []);
    assert.ok(!whole.warnings.some((sentence) => /lost|moved/.test(sentence)), whole.warnings.join());
    const wrong = [];
    for (const [i, [name, change, expected]] of faults.entries()) {
        const file = new Faulty(studio.pathOf(base));
        change(file);
        writeGlb(studio.pathOf(`broken-${i}`), file);
        const { refused, warnings = [], errors = [] } = await page.evaluate(attempt, `/files/broken-${i}.glb`);
        const fits = (sentence) => (typeof expected === 'string' ? sentence.includes(expected) : expected.test(sentence));
        const isPath = typeof expected !== 'string' || expected.startsWith('/');
        const good = isPath ? refused !== undefined && fits(refused) : refused === undefined && errors.length === 0 && warnings.some(fits);
        if (!good) wrong.push(`${name}: ${refused ?? `shown: ${[...warnings, ...errors].join(' | ')}`}`);
        const program = programsWords(studio.pathOf(`broken-${i}`));
        const same = program.path ? refused?.startsWith(`${program.path}: `) : program.warnings.length > 0 && warnings.some((sentence) => sentence.includes(program.warnings[0]));
        if (!same) wrong.push(`${name}: the program says ${JSON.stringify(program)}, the plug-in ${refused ?? warnings.join(' | ')}`);
    }
    return wrong;
}
