// The plug-in's pictures by WebGPURenderer, on WebGPU and on WebGL 2, against the program's and WebGLRenderer's.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { missing } from './harness.mjs';
import { SIZE, Studio } from './studio.mjs';

const reason = missing();
if (reason) {
    console.log(`[  SKIPPED ] web.webgpu: ${reason}`);
    process.exit(0);
}

const studio = new Studio();
after(() => studio.close());

const scenes = [
    { label: 'sphere on floor', scene: 'tests/sphere_on_floor', modes: ['realtime', 'baked-indirect', 'shadowmask', 'distance-shadowmask'] },
    { label: 'subtractive', scene: 'tests/sphere_on_floor', bake: ['--mode', 'subtractive'], modes: ['subtractive'] },
    { label: 'a fully baked light', scene: 'tests/five_lights', modes: ['shadowmask', 'distance-shadowmask'] },
    { label: 'directional lightmap', scene: 'tests/bumpy_wall', bake: ['--directional', 'on'], modes: ['shadowmask'] },
    { label: 'proxy volumes', scene: 'tests/proxy_volume', modes: ['shadowmask'] },
    { label: 'instances', scene: 'tests/instances_1023', modes: ['shadowmask'] },
    { label: 'distance field', scene: 'tests/avenue', bake: ['--shadowmask-encoding', 'distance-field'], modes: ['shadowmask'], settings: { shadowDistance: 20, shadowFadeRange: 4 } },
];

for (const { label, scene, bake: options = [], modes, settings } of scenes) {
    test(`${label}, WebGPU`, async () => {
        const name = label.replaceAll(' ', '-');
        studio.bake(scene, name, ...options);
        const { call } = await studio.pageOf('three', 'webgpu');
        await call('load', { file: `/files/${name}.glb` });
        for (const mode of modes) await studio.compare(call, `${label}, WebGPU`, mode, { name, settings });
    });
}

test('debug views, WebGPU', async () => {
    studio.bake('tests/five_lights', 'a-fully-baked-light');
    const { call } = await studio.pageOf('three', 'webgpu');
    await call('load', { file: '/files/a-fully-baked-light.glb' });
    for (const view of ['shadowmask', 'lightmap', 'probes', 'fade', 'overlap']) {
        const settings = { debugView: view, shadowDistance: 8, shadowFadeRange: 5 };
        await studio.compare(call, `view ${view}, WebGPU`, 'shadowmask', { name: 'a-fully-baked-light', settings, options: ['--view', view] });
    }
});

test('WebGL, WebGPU and its WebGL 2 agree inside surfaces', async () => {
    studio.bake('tests/five_lights', 'a-fully-baked-light');
    const camera = studio.reference('a-fully-baked-light', 'shadowmask', []);
    let first = null;
    for (const renderer of ['webgl', 'webgpu', 'webgl2-nodes']) {
        const { call } = await studio.pageOf('three', renderer);
        await call('load', { file: '/files/a-fully-baked-light.glb' });
        await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask', debugView: 'lit' } });
        if (!first) {
            first = await call('picture');
            continue;
        }
        const result = await call('agreement', { other: first });
        console.log(`${renderer} and WebGL: mean ${result.mean.toFixed(4)} of 255; ${(100 * result.within).toFixed(2)} % of pixels within 1/255`);
        // Silhouettes and shadow edges are the rest.
        assert.ok(result.mean <= 0.2 && result.within >= 0.98, JSON.stringify(result));
    }
});

test('other releases', async () => {
    studio.bake('tests/five_lights', 'a-fully-baked-light');
    for (const three of ['three-0.186', 'three-0.185']) {
        const { call } = await studio.pageOf(three, 'webgpu');
        await call('load', { file: '/files/a-fully-baked-light.glb' });
        await studio.compare(call, `five lights, ${three}, WebGPU`, 'shadowmask', { name: 'a-fully-baked-light' });
    }
});

test('dispose gives everything back, WebGPU', async () => {
    studio.bake('tests/five_lights', 'a-fully-baked-light');
    const { call } = await studio.pageOf('three', 'webgpu');
    const camera = studio.reference('a-fully-baked-light', 'shadowmask', []);
    const result = await call('disposeTest', { file: '/files/a-fully-baked-light.glb', width: SIZE[0], height: SIZE[1], camera });
    assert.deepEqual(result.changed, []);
    assert.ok(result.largest < 1e-6, `three.js draws the file as without the plug-in: ${result.largest}`);
    assert.ok(result.withPlugin > 0.01, 'and the plug-in had made a difference');
});
