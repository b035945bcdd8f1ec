// The glTF Transform package: light groups (spec S33) are written as they were read, and what tools do to materials does not
// change what a weight gives.
import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { readGlb, writeGlb } from './glb.mjs';
import { findProgram, halflight, repository, web } from './harness.mjs';

const reason = !existsSync(join(web, 'node_modules/@gltf-transform/core')) ? 'no packages found: run npm install in web/' : findProgram() ? null : 'no halflight program found: build it, or set HALFLIGHT_PROGRAM';
if (reason) {
    console.log(`[  SKIPPED ] web.gltf_transform: ${reason}`);
    process.exit(0);
}
const { Document, Logger, NodeIO } = await import('@gltf-transform/core');
const { ALL_EXTENSIONS, KHRMaterialsEmissiveStrength } = await import('@gltf-transform/extensions');
const { palette } = await import('@gltf-transform/functions');
const { HALFLIGHT_EXTENSIONS, HalflightMaterial } = await import('../gltf-transform/src/index.js');

const folder = mkdtempSync(join(tmpdir(), 'halflight-transform-'));
after(() => rmSync(folder, { recursive: true }));
const io = () => new NodeIO().setLogger(new Logger(Logger.Verbosity.SILENT)).registerExtensions([...ALL_EXTENSIONS, ...HALFLIGHT_EXTENSIONS]);

/** What a file says of its groups, with bytes in place of indices. */
function groupsOf(path) {
    const { json, buffer } = readGlb(path);
    const bytesOf = (view) => buffer.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength).toString('base64');
    const picture = ({ index }) => {
        if (index === undefined) return null;
        const texture = json.textures[index];
        const { mimeType, bufferView } = json.images[Object.values(texture.extensions ?? {})[0]?.source ?? texture.source];
        return { mimeType, bytes: bytesOf(json.bufferViews[bufferView]), sampler: json.samplers[texture.sampler] };
    };
    const numbers = (index) => {
        const { bufferView, byteOffset = 0, count, type, componentType } = json.accessors[index];
        const view = json.bufferViews[bufferView];
        return { count, type, componentType, bytes: bytesOf({ byteOffset: (view.byteOffset ?? 0) + byteOffset, byteLength: 12 * count }) };
    };
    const { groups, sky } = json.extensions.HALFLIGHT_mixed_lighting;
    const members = (list, extension) => list.filter(({ extensions }) => extensions?.[extension]?.baking?.group !== undefined).map(({ name, extensions }) => ({ name, ...extensions[extension].baking }));
    return {
        groups: groups.map(({ lightmaps, lightmapDirections, radiance, reflections, ...rest }) => ({ ...rest, lightmaps: lightmaps.map(picture), reflections: { ...reflections, picture: picture(reflections.picture) }, directions: lightmapDirections?.map(picture), radiance: numbers(radiance) })),
        sky: sky.group,
        lights: members(json.nodes, 'HALFLIGHT_light'),
        materials: members(json.materials, 'HALFLIGHT_material').sort((a, b) => a.group - b.group),
    };
}

test('gltf-transform S33: a file with light groups comes back with them', async () => {
    const baked = join(folder, 'baked.glb');
    const copy = join(folder, 'copy.glb');
    const options = ['--quality', 'preview', '--samples', '16', '--texels-per-meter', '5', '--lightmap-size', '64', '--directional', 'on', '--probe-layout', 'grid', '--probe-spacing', '1', '--reflection-probes', 'on', '-q'];
    halflight('bake', join(repository, 'assets/tests/light_groups.glb'), '-o', baked, ...options);
    const file = readGlb(baked);
    const [first] = file.json.extensions.HALFLIGHT_mixed_lighting.groups;
    first.lightmaps[0] = {}; // a page without light
    first.shadowColor = [0.25, 0.5, 1];
    writeGlb(baked, file);
    await io().write(copy, await io().read(baked));
    const before = groupsOf(baked);
    assert.equal(before.groups.length, 5);
    assert.ok(before.groups.some(({ lightmaps }) => lightmaps.includes(null)), 'a page without light');
    assert.ok(before.groups.some(({ directions }) => directions?.some(Boolean)), 'directions');
    assert.ok(before.lights.length === 2 && before.materials.length === 2 && before.sky === 'day', JSON.stringify([before.lights, before.materials, before.sky]));
    assert.ok(before.groups.every(({ reflections }) => reflections.size === 64 && reflections.picture.mimeType === 'image/ktx2'), 'pictures of reflections');
    assert.deepEqual(groupsOf(copy), before);
    const { groups, warnings } = JSON.parse(halflight('info', '--json', copy));
    assert.equal(groups.length, 5);
    assert.deepEqual(warnings.filter((sentence) => /lost|stale/.test(sentence)), []);
});

test('gltf-transform S34: a sun that turns comes back with its directions', async () => {
    const source = readGlb(join(repository, 'assets/tests/light_groups.glb'));
    const directions = [[-0.56, -0.6, -0.57], [-0.36, -0.6, -0.72]];
    source.json.nodes.find(({ name }) => name === 'sun').extras = { halflight_mode: 'mixed', halflight_directions: directions };
    const [scene, baked, copy] = ['turning.glb', 'turning-baked.glb', 'turning-copy.glb'].map((name) => join(folder, name));
    writeGlb(scene, source);
    halflight('bake', scene, '-o', baked, '--quality', 'preview', '--samples', '16', '--texels-per-meter', '3', '--reflection-probes', 'off', '-q');
    await io().write(copy, await io().read(baked));
    const recordOf = (path) => readGlb(path).json.nodes.find(({ name }) => name === 'sun').extensions.HALFLIGHT_light;
    assert.equal(recordOf(baked).baking.turns.directions.length, 2);
    assert.deepEqual(recordOf(copy), recordOf(baked));
    const groupsOfSun = (path) => JSON.parse(halflight('info', '--json', path)).groups.filter(({ direction }) => direction).map(({ name, direction, weight }) => ({ name, direction, weight }));
    assert.deepEqual(groupsOfSun(copy).map(({ name }) => name), ['sun.1', 'sun.2']);
    assert.deepEqual(groupsOfSun(copy), groupsOfSun(baked));
});

/** Materials of one colour of emission each, `member` of a light group. */
function emitters(factors, member, baking) {
    const document = new Document().setLogger(new Logger(Logger.Verbosity.SILENT));
    const buffer = document.createBuffer();
    const extension = document.createExtension(HalflightMaterial);
    const strength = document.createExtension(KHRMaterialsEmissiveStrength);
    const mesh = document.createMesh();
    factors.forEach((factor, i) => {
        const material = document.createMaterial(`glow ${i}`).setEmissiveFactor(factor).setExtension('KHR_materials_emissive_strength', strength.createEmissiveStrength().setEmissiveStrength(30));
        if (i === member) material.setExtension('HALFLIGHT_material', extension.createMaterialSwitches().setRecord({ castShadows: true, baking }));
        const position = document.createAccessor().setType('VEC3').setArray(new Float32Array(9)).setBuffer(buffer);
        mesh.addPrimitive(document.createPrimitive().setAttribute('POSITION', position).setMaterial(material));
    });
    document.createScene().addChild(document.createNode().setMesh(mesh));
    return document;
}

test('gltf-transform S33: emission that palette() moved into a texture follows its weight as before', async () => {
    const factor = [1, 0.5, 0.25];
    const weight = [0.5, 0.5, 0.25];
    const factors = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], factor];
    const source = emitters(factors, 5, { group: 0, white: factor.map((x, c) => (30 * x) / weight[c]) });
    const document = await io().readBinary(await io().writeBinary(source));
    await document.transform(palette({ min: 2 }));
    const written = await io().readBinary(await io().writeBinary(document));
    const material = written.getRoot().listMaterials().find((own) => own.getExtension('HALFLIGHT_material'));
    assert.deepEqual(material.getEmissiveFactor(), [1, 1, 1]);
    assert.ok(material.getEmissiveTexture(), 'the palette');
    const { white } = material.getExtension('HALFLIGHT_material').getRecord().baking;
    // The texture holds the factor, the strength stays: at the saved weight the material emits what it did.
    for (let c = 0; c < 3; ++c) assert.ok(Math.abs(white[c] * weight[c] * factor[c] - 30 * factor[c]) < 1e-4, `channel ${c}: ${white}`);
});

test('gltf-transform S33: a lamp that is off and in a palette has a sentence', async () => {
    const said = [];
    const factors = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], [0, 0, 0]];
    const source = emitters(factors, 5, { group: 0, white: [1, 1, 1] });
    const document = await io().readBinary(await io().writeBinary(source));
    await document.transform(palette({ min: 2 }));
    document.setLogger({ debug() {}, info() {}, error() {}, warn: (text) => said.push(text) });
    await io().writeBinary(document);
    assert.ok(said.some((text) => /was off and can no longer be switched on/.test(text)), said.join());
});
