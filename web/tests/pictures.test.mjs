// The plug-in's pictures in a real browser against those of the program. Figures are printed; pictures go to
// HALFLIGHT_WEB_PICTURES where it names a folder.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import { halflight, launch, missing, openPage, repository, serve } from './harness.mjs';

const reason = missing();
if (reason) {
    console.log(`[  SKIPPED ] web.pictures: ${reason}`);
    process.exit(0);
}

const SIZE = [480, 270];
const LIMIT = 1.5; // mean difference in 255ths
const look = process.env.HALFLIGHT_WEB_PICTURES;
const files = mkdtempSync(join(tmpdir(), 'halflight-web-'));
const baked = new Set();
let browser;
const servers = new Map();
const pages = new Map();

before(async () => {
    if (look) mkdirSync(look, { recursive: true });
    browser = await launch();
});
after(async () => {
    await browser?.close();
    for (const server of servers.values()) server.close();
    rmSync(files, { recursive: true });
});

/** The test page with a release of three.js. */
async function pageOf(three) {
    if (!pages.has(three)) {
        servers.set(three, await serve(files, three));
        pages.set(three, await openPage(browser, servers.get(three).url));
    }
    return pages.get(three);
}

function bake(scene, name, ...options) {
    if (baked.has(name)) return;
    halflight('bake', join(repository, 'assets', `${scene}.glb`), '-o', join(files, `${name}.glb`), '--quality', 'preview', '-q', ...options);
    baked.add(name);
}

/** The program's picture, and what the page needs to draw the same. */
function reference(name, mode, options) {
    const picture = join(files, 'reference.exr');
    const size = SIZE.join('x');
    const info = JSON.parse(halflight('render', join(files, `${name}.glb`), '-o', picture, '--mode', mode, '--samples', '1', '--size', size, '--json', ...options));
    return { fov: info.camera.verticalFovDegrees, eye: info.camera.eye, target: info.camera.target };
}

async function compare(call, label, mode, { name, settings = {}, options = [] }) {
    const shadow = ['--shadow-distance', String(settings.shadowDistance ?? 60), '--shadow-fade-range', String(settings.shadowFadeRange ?? 1)];
    const camera = reference(name, mode, [...shadow, ...options]);
    const drawn = await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { shadowDistance: 60, shadowFadeRange: 1, ...settings, mode } });
    const result = await call('compare', { reference: '/files/reference.exr', pictures: look !== undefined });
    for (const picture of look ? ['ours', 'reference', 'difference'] : [])
        writeFileSync(join(look, `${label} ${mode} ${picture}.png`.replaceAll(' ', '-')), Buffer.from(result[picture], 'base64'));
    const figures = ['linear', 'encoded', 'median', 'p99'].map((key) => `${key} ${result[key].toFixed(3)}`).join(', ');
    console.log(`${label}, ${mode}: ${figures} of 255; ${drawn.calls} draw calls`);
    assert.ok(result.linear <= LIMIT, `${label}, ${mode}: mean difference ${result.linear} of 255`);
    assert.ok(result.encoded <= LIMIT, `${label}, ${mode}: mean difference ${result.encoded} of 255, sRGB-encoded`);
    return { ...result, ...drawn };
}

const MIXED = ['realtime', 'baked-indirect', 'shadowmask', 'distance-shadowmask'];
const scenes = [
    { label: 'courtyard', scene: 'courtyard', modes: MIXED },
    { label: 'sphere on floor', scene: 'tests/sphere_on_floor', modes: MIXED },
    { label: 'subtractive', scene: 'tests/sphere_on_floor', bake: ['--mode', 'subtractive'], modes: ['subtractive', 'realtime'] },
    { label: 'subtractive without mask', scene: 'tests/sphere_on_floor', bake: ['--mode', 'subtractive', '--subtractive-mask', 'off'], modes: ['subtractive'] },
    { label: 'baked indirect', scene: 'tests/four_lights', bake: ['--mode', 'baked-indirect'], modes: ['baked-indirect'] },
    { label: 'four masks', scene: 'tests/four_lights', modes: ['shadowmask'] },
    { label: 'a fully baked light', scene: 'tests/five_lights', modes: ['shadowmask', 'realtime'] },
    { label: 'directional lightmap', scene: 'tests/bumpy_wall', bake: ['--directional', 'on'], modes: ['shadowmask'] },
    { label: 'proxy volumes', scene: 'tests/proxy_volume', modes: ['shadowmask'] },
    { label: 'instances', scene: 'tests/instances_1023', modes: ['shadowmask'] },
    { label: 'shadow distance', scene: 'tests/avenue', modes: ['shadowmask', 'distance-shadowmask'], settings: { shadowDistance: 20, shadowFadeRange: 4 } },
    { label: 'distance field', scene: 'tests/avenue', bake: ['--shadowmask-encoding', 'distance-field'], modes: ['shadowmask'] },
];

for (const { label, scene, bake: options = [], modes, settings } of scenes) {
    test(label, async () => {
        const name = label.replaceAll(' ', '-');
        bake(scene, name, ...options);
        const { call } = await pageOf('three');
        await call('load', { file: `/files/${name}.glb` });
        for (const mode of modes) await compare(call, label, mode, { name, settings });
    });
}

test('casters by mode: static objects leave the shadow maps of shadowmask mode', async () => {
    bake('tests/five_lights', 'a-fully-baked-light');
    for (const three of ['three', 'three-0.186', 'three-0.185']) {
        const { call } = await pageOf(three);
        await call('load', { file: '/files/a-fully-baked-light.glb' });
        const calls = {};
        for (const mode of ['shadowmask', 'distance-shadowmask']) {
            const result = await compare(call, `five lights, ${three}`, mode, { name: 'a-fully-baked-light' });
            calls[mode] = result.calls;
        }
        assert.ok(calls.shadowmask < calls['distance-shadowmask'] / 2, `${three}: ${JSON.stringify(calls)} draw calls`);
    }
});

test('lights changed at run time', async () => {
    bake('tests/four_lights', 'four-masks');
    const { call } = await pageOf('three');
    await call('load', { file: '/files/four-masks.glb' });
    const names = await call('lightNames');
    await call('changeLight', { index: 0, intensity: 3, strength: 0.5 });
    const options = ['--light', `${names[0]}:intensity=${await call('intensityOf', { index: 0 })},strength=0.5`];
    await compare(call, 'changed light', 'shadowmask', { name: 'four-masks', options });
});

test('debug views', async () => {
    bake('tests/four_lights', 'four-masks');
    const { call } = await pageOf('three');
    await call('load', { file: '/files/four-masks.glb' });
    for (const view of ['shadowmask', 'lightmap', 'probes', 'fade', 'overlap'])
        await compare(call, `view ${view}`, 'shadowmask', { name: 'four-masks', settings: { debugView: view }, options: ['--view', view] });
});

test('penumbra: the mask and the lit floor have their known values', async () => {
    bake('tests/penumbra', 'penumbra', '--shadow-samples', '1024');
    const { call } = await pageOf('three');
    await call('load', { file: '/files/penumbra.glb' });
    const camera = reference('penumbra', 'shadowmask', []);
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
    bake('tests/five_lights', 'a-fully-baked-light');
    const { call } = await pageOf('three');
    const camera = reference('a-fully-baked-light', 'shadowmask', []);
    const result = await call('disposeTest', { file: '/files/a-fully-baked-light.glb', width: SIZE[0], height: SIZE[1], camera });
    assert.deepEqual(result.changed, []);
    assert.equal(result.largest, 0, 'three.js draws the file as without the plug-in');
    assert.ok(result.withPlugin > 0.01, 'and the plug-in had made a difference');
});

test('other files and modes: one sentence', async () => {
    bake('tests/sphere_on_floor', 'sphere-on-floor');
    const { call } = await pageOf('three');
    await call('load', { file: '/files/sphere-on-floor.glb' });
    const [sentence, plain] = await call('sentences');
    assert.match(sentence, /baked for shadowmask, so it can only be drawn in mode/);
    assert.equal(plain, null);
});
