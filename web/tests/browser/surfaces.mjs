// What the conformance pack's plain materials and objects leave out, by each renderer.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { studio } from './studio.mjs';

for (const renderer of ['webgl', 'webgpu']) {
    test(`indirect specular light: metal reflects lightmap, probes and sky, ${renderer}`, async () => {
        const file = readGlb(studio.pathOf('conformance/sphere_on_floor'));
        for (const material of file.json.materials) {
            material.pbrMetallicRoughness ??= {};
            Object.assign(material.pbrMetallicRoughness, { metallicFactor: 1, roughnessFactor: 0.3 });
        }
        writeGlb(studio.pathOf('metal'), file);
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'metal');
        for (const mode of ['shadowmask', 'realtime']) {
            const { even, evenPixels } = await studio.compare(call, `metal, ${renderer}`, mode, { name: 'metal' });
            assert.ok(evenPixels > 1000 && even >= 0.99, `${even} of the pixels of even surfaces are within 1 %`);
        }
    });

    test(`an object of the application is lit as one of the file, ${renderer}`, async () => {
        const { call } = await studio.pageOf('three', renderer);
        const name = 'conformance/sphere_on_floor';
        await studio.load(call, name);
        const replaced = await call('replaceDynamic');
        assert.equal(replaced, 1, 'dynamic objects of the file');
        for (const mode of ['shadowmask', 'distance-shadowmask']) await studio.compare(call, `own object, ${renderer}`, mode, { name });
    });
}
