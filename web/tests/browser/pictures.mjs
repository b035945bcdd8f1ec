// The plug-in's pictures by WebGLRenderer in a real browser against those of the program.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { SIZE, studio } from './studio.mjs';

const MIXED = ['realtime', 'baked-indirect', 'shadowmask', 'distance-shadowmask'];
// What the conformance pack lacks.
const scenes = [
    { label: 'courtyard', scene: 'courtyard', bake: ['--lightmap-size', '256'], modes: MIXED, size: [480, 270] },
    { label: 'subtractive without mask', scene: 'tests/sphere_on_floor', bake: ['--mode', 'subtractive', '--subtractive-mask', 'off', '--lightmap-format', 'webp'], modes: ['subtractive'] },
    { label: 'baked indirect', scene: 'tests/four_lights', bake: ['--mode', 'baked-indirect', '--lightmap-format', 'half'], modes: ['baked-indirect'] },
    { label: 'sheets', scene: 'tests/sheets', bake: ['--lightmap-size', '256'], modes: MIXED },
    { label: 'instances', scene: 'tests/instances_1023', bake: ['--lightmap-size', '256'], modes: ['shadowmask'] },
    { label: 'distance field', scene: 'tests/avenue', bake: ['--shadowmask-encoding', 'distance-field'], modes: ['shadowmask', 'distance-shadowmask'], settings: { shadowDistance: 20, shadowFadeRange: 4 } },
];

for (const { label, scene, bake: options = [], modes, settings, size } of scenes) {
    test(label, async () => {
        const name = label.replaceAll(' ', '-');
        studio.bake(scene, name, ...options);
        const { call } = await studio.pageOf('three');
        await studio.load(call, name);
        for (const mode of modes) await studio.compare(call, label, mode, { name, settings, size });
    });
}

for (const renderer of ['webgl', 'webgpu']) {
    test(`casters by mode: static objects leave the shadow maps of shadowmask mode, ${renderer}`, async () => {
        const name = 'conformance/five_lights';
        const draw = async (three, mode) => {
            const { call } = await studio.pageOf(three, renderer);
            await studio.load(call, name);
            return (await studio.compare(call, `five lights, ${three}, ${renderer}`, mode, { name })).calls;
        };
        const all = await draw('three', 'distance-shadowmask');
        for (const three of ['three', 'three-0.186', 'three-0.185']) {
            const dynamic = await draw(three, 'shadowmask');
            assert.ok(dynamic < all / 2, `${three}: ${dynamic} draw calls, ${all} with static casters`);
        }
    });
}

for (const renderer of ['webgl', 'webgpu']) {
    test(`lights changed at run time, ${renderer}`, async () => {
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'conformance/five_lights');
        const names = await call('lightNames');
        await call('changeLight', { index: 0, intensity: 3, strength: 0.5 });
        const options = ['--light', `${names[0]}:intensity=${await call('intensityOf', { index: 0 })},strength=0.5`];
        const { warnings } = await studio.compare(call, `changed light, ${renderer}`, 'shadowmask', { name: 'conformance/five_lights', options });
        assert.deepEqual(warnings.filter((sentence) => sentence.includes('moved')), []);
        // A light that moved is drawn where it is; its baked shadows stay, and a sentence says so.
        await call('moveLight', { index: 0, by: [0.3, 0, 0] });
        const moved = await call('draw', { width: 64, height: 36, camera: 'main', settings: { mode: 'shadowmask' } });
        assert.ok(moved.warnings.some((sentence) => sentence.startsWith(`light "${names[0]}" moved since its bake`)), moved.warnings.join());
    });
}

test('debug views', async () => {
    const { call } = await studio.pageOf('three');
    await studio.load(call, 'conformance/five_lights');
    for (const view of ['shadowmask', 'lightmap', 'probes', 'fade', 'overlap'])
        await studio.compare(call, `view ${view}`, 'shadowmask', { name: 'conformance/five_lights', settings: { debugView: view, shadowDistance: 8, shadowFadeRange: 5 }, options: ['--view', view] });
});

test('penumbra: the mask and the lit floor have their known values', async () => {
    studio.bake('tests/penumbra', 'penumbra', '--shadow-samples', '1024');
    const { call } = await studio.pageOf('three');
    await studio.load(call, 'penumbra');
    const { camera } = studio.reference('penumbra', 'shadowmask');
    const draw = (settings) => call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask', debugView: 'lit', ...settings } });
    await draw({ debugView: 'shadowmask' });
    const width = 2 * Math.tan((2 * Math.PI) / 180);
    for (const x of [-0.5, -0.2, 0.2, 0.5]) {
        const [{ value, at }] = await call('atPoints', { points: [[x, 0, 0.5]], camera });
        const t = Math.min(Math.max(at[0] / width, -1), 1);
        const exact = 0.5 + (t * Math.sqrt(1 - t * t) + Math.asin(t)) / Math.PI;
        assert.ok(Math.abs(value[0] - exact) <= 0.01, `attenuation at x = ${at[0]}: ${value[0]}, exact ${exact}`);
    }
    // pi lux straight down on albedo 0.8, roughness 1: the diffuse part is 0.8 (1 - F), the lobe F D V pi.
    await draw({ mode: 'realtime' });
    const [{ value, at }] = await call('atPoints', { points: [[0.9, 0, 0.5]], camera });
    const v = camera.eye.map((x, i) => x - at[i]);
    const length = Math.hypot(...v);
    const cosine = v[1] / length;
    const half = Math.sqrt(0.5 + 0.5 * cosine); // between the view and the normal, which is the light's direction
    const f = 0.04 + 0.96 * (1 - half) ** 5;
    const exact = 0.8 * (1 - f) + (f * (1 / Math.PI) * 0.5 * Math.PI) / (cosine + 1);
    for (const x of value) assert.ok(Math.abs(x / exact - 1) <= 0.01, `radiance ${value}, exact ${exact}`);
});

test('dispose gives everything back', async () => {
    const { call } = await studio.pageOf('three');
    const { camera } = studio.reference('conformance/five_lights', 'shadowmask');
    const result = await call('disposeTest', { file: '/assets/conformance/five_lights.glb', width: SIZE[0], height: SIZE[1], camera });
    assert.deepEqual(result.changed, []);
    assert.equal(result.largest, 0, 'three.js draws the file as without the plug-in');
    assert.equal(result.ownSize, 512, "the application's shadow map keeps its size");
    assert.ok(result.withPlugin > 0.01, 'and the plug-in had made a difference');
});

test('other files and modes: one sentence', async () => {
    const { call } = await studio.pageOf('three');
    await studio.load(call, 'conformance/sphere_on_floor');
    const [sentence, plain] = await call('sentences');
    assert.match(sentence, /baked for shadowmask, so it can only be drawn in mode/);
    assert.equal(plain, null);
});
