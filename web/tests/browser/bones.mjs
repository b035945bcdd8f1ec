// Meshes with bones: they take the light of where the bones hold them, not of where their node is.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';

import { halflight, repository } from '../harness.mjs';
import { readGlb, writeGlb } from '../glb.mjs';
import { studio } from './studio.mjs';

const SIZE = [160, 90];
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** Adds values to a file. @returns {number} their accessor */
function addAccessor(file, array, componentType, type, count) {
    const bytes = Buffer.from(array.buffer);
    file.json.bufferViews.push({ buffer: 0, byteOffset: file.buffer.length, byteLength: bytes.length });
    file.buffer = Buffer.concat([file.buffer, bytes, Buffer.alloc(-bytes.length & 3)]);
    file.json.buffers[0].byteLength = file.buffer.length;
    return file.json.accessors.push({ bufferView: file.json.bufferViews.length - 1, componentType, type, count }) - 1;
}

/** Two rooms of different light: a block is in the east by its bone, in the west by its node. */
function bakeBones() {
    if (studio.baked.has('bones')) return;
    const file = readGlb(join(repository, 'assets/tests/two_rooms.glb'));
    const { json } = file;
    const block = json.nodes.find((node) => node.name === 'block_east');
    const mesh = structuredClone(json.meshes[block.mesh]);
    const { attributes } = mesh.primitives[0];
    const { count } = json.accessors[attributes.POSITION];
    attributes.JOINTS_0 = addAccessor(file, new Uint8Array(4 * count), 5121, 'VEC4', count);
    attributes.WEIGHTS_0 = addAccessor(file, Float32Array.from({ length: 4 * count }, (_, i) => (i % 4 === 0 ? 1 : 0)), 5126, 'VEC4', count);
    json.skins = [{ joints: [json.nodes.length], inverseBindMatrices: addAccessor(file, Float32Array.from(IDENTITY), 5126, 'MAT4', 1) }];
    json.scenes[0].nodes.push(json.nodes.push({ name: 'bone', translation: [5.5, 0.6, -0.4] }) - 1);
    Object.assign(block, { mesh: json.meshes.push(mesh) - 1, skin: 0, translation: [-5.5, 0.6, -0.4], extras: { halflight_static: 0 } });
    writeGlb(studio.pathOf('bones-source'), file);
    halflight('bake', studio.pathOf('bones-source'), '-o', studio.pathOf('bones'), '--quality', 'preview', '-q');
    studio.baked.add('bones');
}

for (const renderer of ['webgl', 'webgpu']) {
    test(`bones: a mesh is lit where its bones are, also in a clone, ${renderer}`, async () => {
        bakeBones();
        const { call } = await studio.pageOf('three', renderer);
        for (const copy of [null, 'skeleton']) {
            await call('load', { file: '/files/bones.glb' });
            if (copy) await call('put', { translation: [40, 0, 0], copy, alone: true });
            const { even } = await studio.compare(call, `bones, ${copy ?? 'loaded'}, ${renderer}`, 'shadowmask', { name: 'bones', size: SIZE, options: ['--camera', 'east'] });
            assert.ok(even >= 0.998, `${even} of the even pixels within 1 %`);
        }
    });
}

test('bones: light follows a bone, and rests with it', async () => {
    bakeBones();
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: '/files/bones.glb' });
    const result = await page.evaluate(async () => {
        const { loaded, makeRenderer, viewOf } = window.halflightPage;
        const { halflight, gltf } = loaded;
        const renderer = await makeRenderer(32, 18);
        const object = halflight.objects.find(({ meshes }) => meshes[0].isSkinnedMesh);
        const bone = gltf.scene.getObjectByName('bone');
        const update = () => {
            const before = object.light.radiance.slice();
            object.light.radiance.fill(-1);
            halflight.update(renderer, viewOf('main', 16 / 9));
            const changed = object.light.radiance[0] !== -1;
            if (!changed) object.light.radiance.set(before);
            return { changed, radiance: [...object.light.radiance], at: [...object.anchor] };
        };
        halflight.update(renderer, viewOf('main', 16 / 9)); // the first gives it its light
        const first = update();
        const rests = update();
        bone.position.x -= 11;
        const west = update();
        const exact = [first, west].map(({ at }) => [...halflight.field.sample(Float64Array.from(at)).radiance]);
        return { first, rests, west, exact };
    });
    const { first, rests, west, exact } = result;
    assert.ok(!rests.changed, 'nothing is computed at rest');
    assert.ok(west.changed && Math.abs(first.at[0] - west.at[0] - 11) < 1e-4, `${first.at} to ${west.at}`);
    for (const [i, { radiance }] of [first, west].entries())
        radiance.forEach((x, k) => assert.ok(Math.abs(x - exact[i][k]) <= 1e-5 * Math.max(Math.abs(x), 1), `${x} is not ${exact[i][k]}`));
    assert.ok(Math.abs(west.radiance[0] / west.radiance[2] - first.radiance[0] / first.radiance[2]) > 0.1, 'the rooms have light of different colours');
});
