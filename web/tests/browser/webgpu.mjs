// The plug-in's pictures by WebGPURenderer, on WebGPU and on WebGL 2, against the program's and WebGLRenderer's.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { SIZE, studio } from './studio.mjs';

// What the conformance pack lacks.
const scenes = [
    { label: 'instances', scene: 'tests/instances_1023', bake: ['--lightmap-size', '256'], modes: ['shadowmask'] },
    { label: 'distance field', scene: 'tests/avenue', bake: ['--shadowmask-encoding', 'distance-field'], modes: ['shadowmask'], settings: { shadowDistance: 20, shadowFadeRange: 4 } },
];

for (const { label, scene, bake: options = [], modes, settings } of scenes) {
    test(`${label}, WebGPU`, async () => {
        const name = label.replaceAll(' ', '-');
        studio.bake(scene, name, ...options);
        const { call } = await studio.pageOf('three', 'webgpu');
        await studio.load(call, name);
        for (const mode of modes) await studio.compare(call, `${label}, WebGPU`, mode, { name, settings });
    });
}

test('debug views, WebGPU', async () => {
    const { call } = await studio.pageOf('three', 'webgpu');
    await studio.load(call, 'conformance/five_lights');
    for (const view of ['shadowmask', 'lightmap', 'probes', 'fade', 'overlap']) {
        const settings = { debugView: view, shadowDistance: 8, shadowFadeRange: 5 };
        await studio.compare(call, `view ${view}, WebGPU`, 'shadowmask', { name: 'conformance/five_lights', settings, options: ['--view', view] });
    }
});

test('WebGL, WebGPU and its WebGL 2 agree inside surfaces', async () => {
    const { camera } = studio.reference('conformance/five_lights', 'shadowmask');
    let first = null;
    for (const renderer of ['webgl', 'webgpu', 'webgl2-nodes']) {
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'conformance/five_lights');
        await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask', debugView: 'lit', shadowDistance: 60, shadowFadeRange: 1 } });
        if (!first) {
            first = await call('picture');
            continue;
        }
        const result = await call('agreement', { other: first });
        console.log(`${renderer} and WebGL: mean ${result.mean.toFixed(4)} of 255; ${(100 * result.within).toFixed(2)} % of pixels within 1/255, ${(100 * result.inside).toFixed(2)} % of ${result.insidePixels} inside surfaces`);
        // Silhouettes and shadow edges are the rest.
        assert.ok(result.mean <= 0.02 && result.within >= 0.998, JSON.stringify(result));
        assert.ok(result.insidePixels > 20000 && result.inside === 1, JSON.stringify(result));
    }
});

test('dispose gives everything back, WebGPU', async () => {
    const { call } = await studio.pageOf('three', 'webgpu');
    const { camera } = studio.reference('conformance/five_lights', 'shadowmask');
    const result = await call('disposeTest', { file: '/assets/conformance/five_lights.glb', width: SIZE[0], height: SIZE[1], camera });
    assert.deepEqual(result.changed, []);
    assert.ok(result.largest < 1e-6, `three.js draws the file as without the plug-in: ${result.largest}`);
    assert.ok(result.withPlugin > 0.01, 'and the plug-in had made a difference');
});
