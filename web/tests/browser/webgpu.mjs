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
    assert.equal(result.ownSize, 512, "the application's shadow map keeps its size");
    assert.ok(result.withPlugin > 0.01, 'and the plug-in had made a difference');
});

/** Draws into a pass with colour, normals and emission, as screen-space effects want it. Runs in the page. */
async function drawOutputs({ camera, size }) {
    const { THREE, loaded, draw, makeRenderer, viewOf } = window.halflightPage;
    const { emissive, mrt, normalView, output } = await import('three/tsl');
    const [width, height] = size;
    await draw({ width, height, camera, settings: { mode: 'shadowmask', debugView: 'lit' } });
    const { rows } = loaded.picture;
    const r = await makeRenderer(width, height);
    const target = new THREE.RenderTarget(width, height, { count: 3, type: THREE.HalfFloatType });
    ['output', 'normal', 'emissive'].forEach((name, i) => { target.textures[i].name = name; });
    const view = viewOf(camera, width / height);
    loaded.halflight.update(r, view);
    r.setMRT(mrt({ output, normal: normalView, emissive }));
    r.setRenderTarget(target);
    r.render(loaded.scene, view);
    const read = async (i) => Float32Array.from(await r.readRenderTargetPixelsAsync(target, 0, 0, width, height, i), THREE.DataUtils.fromHalfFloat);
    const [color, normal] = [await read(0), await read(1)];
    r.setMRT(null);
    r.setRenderTarget(null);
    target.dispose();
    const up = new THREE.Vector3(0, 1, 0).transformDirection(view.matrixWorldInverse).toArray();
    const rowOf = (y) => {
        let largest = 0;
        let light = 0;
        let level = 0;
        for (let x = 0; x < width; ++x) {
            const at = y * width + x;
            for (let c = 0; c < 3; ++c) {
                largest = Math.max(largest, Math.abs(color[4 * at + c] - rows[3 * at + c]) / (0.01 + rows[3 * at + c]));
                light += rows[3 * at + c] / width;
            }
            if (Math.hypot(...up.map((u, c) => u - normal[4 * at + c])) < 0.01) level += 1 / width;
        }
        return { largest, light, level };
    };
    return { sky: rowOf(1), floor: rowOf(height - 2) };
}

test('a pass with normals and emission has the sky too, WebGPU', async () => {
    const { page, call } = await studio.pageOf('three', 'webgpu');
    await studio.load(call, 'conformance/sphere_on_floor');
    const errors = [];
    const listen = (message) => message.type() === 'error' && errors.push(message.text());
    page.on('console', listen);
    const { sky, floor } = await page.evaluate(drawOutputs, { camera: { eye: [0, 1.2, 5], target: [0, 1.2, 0], fov: 50 }, size: [160, 90] });
    page.off('console', listen);
    assert.deepEqual(errors, []);
    for (const { largest, light } of [sky, floor]) assert.ok(light > 0.05 && largest < 0.01, `its colour is that of a pass without: ${largest} apart, ${light}`);
    assert.ok(floor.level > 0.99 && sky.level < 0.1, `normals are of the floor: ${floor.level}, ${sky.level}`);
});
