// @halflight/react in a built page, in Strict Mode, with a canvas that draws on demand.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, cpSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { halflight, repository, serve, web } from '../harness.mjs';
import { studio } from '../browser/studio.mjs';
import { compare, makeWorkspace, pictureOf, runIn } from './workspace.mjs';

const SIZE = { width: 320, height: 180 };
const URL = '/files/lights.glb';
const CONFIG = "import react from '@vitejs/plugin-react';\nexport default { base: './', root: 'react_page', plugins: [react()], resolve: { preserveSymlinks: true } };\n";
let opened = null;
after(() => opened?.server.close());

/** The test page, built once; its requests of files and errors are kept. */
async function open() {
    if (opened) return opened;
    copyFileSync(join(repository, 'assets/conformance/five_lights.glb'), studio.pathOf('lights'));
    const folder = makeWorkspace('react');
    cpSync(join(web, 'tests/frameworks/react_page'), join(folder, 'react_page'), { recursive: true });
    writeFileSync(join(folder, 'page.config.js'), CONFIG);
    runIn(folder, 'vite', 'build', '--config', 'page.config.js');
    const decoder = join(web, 'node_modules/three/examples/jsm/libs/draco/');
    const server = await serve(studio.files, 'three', { '/page/': join(folder, 'react_page/dist'), '/draco/': decoder });
    const page = await studio.newPage({ viewport: SIZE });
    const [requests, trouble] = [[], []];
    page.on('request', (request) => request.url().endsWith('.glb') && requests.push(request.url()));
    page.on('pageerror', (error) => trouble.push(String(error)));
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && !/GPU stall|THREE.Clock/.test(message.text()) && trouble.push(message.text()));
    await page.goto(`${server.url}/page/index.html`);
    await page.waitForFunction('window.show !== undefined');
    const { reference, camera, exposure } = pictureOf('lights', SIZE, '--mode', 'shadowmask');
    const view = { fov: camera.verticalFovDegrees, eye: camera.eye, target: camera.target };
    opened = { server, page, requests, trouble, reference, view, exposure };
    return opened;
}

/** Mounts a scene of the page. Models are there when `meshes` are below the scene, once for each. */
async function show(name, props = {}, { offset, models = 1, canvas = {} } = {}) {
    const { page, view, exposure, trouble } = await open();
    trouble.length = 0;
    const argument = [name, props, { ...view, offset }, { exposure, ...canvas }];
    await page.evaluate((list) => window.show(...list), argument);
    const floors = () => page.waitForFunction((count) => {
        let [shown, fallback] = [0, 0];
        window.state?.().scene.traverseVisible((o) => { shown += o.name === 'floor' ? 1 : 0; fallback += o.name === 'fallback' ? 1 : 0; });
        return window.failed !== null || (shown === count && fallback === 0);
    }, models, { polling: 50 });
    await floors();
    assert.equal(await page.evaluate('window.failed'), null);
}

/** Nothing is mounted, and what was is freed. */
async function clear() {
    await show('nothing', {}, { models: 0 });
    const { page } = await open();
    // React cleans up after its commit, then timers free: they are done when the page idles.
    await page.evaluate(() => new Promise((resolve) => requestIdleCallback(() => setTimeout(resolve, 50))));
}

const picture = async () => (await open()).page.evaluate(() => window.picture());
const memory = async () => (await open()).page.evaluate(() => ({ ...window.state().gl.info.memory }));
const compareWith = async (label, reference) => compare((await open()).page, `react, ${label}`, await picture(), reference ?? opened.reference);
const quiet = () => assert.deepEqual(opened.trouble, []);

test('react: one request and one bake for two components of a URL, preloaded', async () => {
    const { page, requests } = await open();
    await clear();
    requests.length = 0;
    await page.evaluate((url) => window.useHalflight.preload(url), URL);
    await show('hook twice', { url: URL, position: [100, 0, 0] }, { models: 2 });
    assert.equal(requests.length, 1, requests.join());
    const same = await page.evaluate(() => {
        const [[gltf, halflight]] = window.held;
        return { all: window.held.every((held) => held[0] === gltf && held[1] === halflight), own: halflight === gltf.userData.halflight && halflight !== null, count: window.held.length };
    });
    assert.ok(same.all && same.own && same.count >= 2, JSON.stringify(same));
    await compareWith('two clones of a hook');
    quiet();
});

test('react: <HalflightModel>, its modes and shadow distance', async () => {
    await clear();
    for (const [mode, distance] of [['shadowmask', 60], ['realtime', 60], ['baked-indirect', 60], ['realtime', 0.1]]) {
        await show('model', { url: URL, mode, shadowDistance: distance });
        const far = distance === 60 ? [] : ['--shadow-distance', String(distance)];
        await compareWith(`model, ${mode}, ${distance} m`, pictureOf('lights', SIZE, '--mode', mode, '--exposure', String(opened.exposure), ...far).reference);
    }
    quiet();
    await show('model', { url: URL, mode: 'shadowmask', shadowDistance: 60 });
    await compareWith('model, shadowmask again');
});

test('react: a mode that the file has no data for is an error of the component', async () => {
    const { page, view } = await open();
    await clear();
    await page.evaluate((list) => window.show(...list), ['model', { url: URL, mode: 'subtractive' }, view, {}]);
    await page.waitForFunction('window.failed !== null');
    assert.match(await page.evaluate('window.failed'), /can only be drawn in mode/);
});

for (const [label, name, props, offset] of [
    ['primitive with a position', 'hook', { position: [3, 1, -2] }, [3, 1, -2]],
    ['drei\'s Clone', 'hook', { position: [3, 1, -2], clones: true }, [3, 1, -2]],
    ['model with a position', 'model', { position: [-20, 5, 8] }, [-20, 5, 8]],
]) {
    test(`react: ${label}`, async () => {
        await clear();
        await show(name, { url: URL, ...props }, { offset });
        await compareWith(label);
        quiet();
    });
}

test('react: two models of a URL, each in its place', async () => {
    await clear();
    const positions = [[0, 0, 0], [100, 0, 30]];
    for (const offset of positions) {
        await show('twice', { url: URL, positions }, { models: 2, offset });
        await compareWith(`two models, at ${offset}`);
    }
    await show('twice', { url: URL, positions: positions.slice(1) }, { models: 1, offset: positions[1] });
    await compareWith('the second alone');
    quiet();
});

test('react: <Center>', async () => {
    const { page } = await open();
    await clear();
    await show('center', { url: URL });
    const offset = await page.evaluate(() => {
        let root = null;
        window.state().scene.traverse((o) => { if (o.userData.halflight?.root) root = o; });
        root.updateWorldMatrix(true, false);
        return [...root.matrixWorld.elements].slice(12, 15);
    });
    assert.ok(Math.hypot(...offset) > 0.1, `it was moved by ${offset}`);
    await show('center', { url: URL }, { offset });
    await compareWith('Center');
    quiet();
});

test('react: on demand a frame is drawn after a change, and none at rest', async () => {
    const { page } = await open();
    await clear();
    await show('model', { url: URL, mode: 'shadowmask' });
    const frames = async (wait) => {
        const before = await page.evaluate('window.frames');
        await page.waitForTimeout(wait);
        return (await page.evaluate('window.frames')) - before;
    };
    await page.waitForTimeout(2000);
    assert.equal(await frames(1500), 0, 'at rest');
    // Settings are no properties of three.js's objects: react-three-fiber alone would draw nothing.
    const before = await page.evaluate('window.frames');
    await show('model', { url: URL, mode: 'realtime' });
    await page.waitForFunction((count) => window.frames > count, before);
    quiet();
});

test('react: updated after controls and before post-processing', async () => {
    const { page, view } = await open();
    await clear();
    for (const composer of [false, true]) {
        await show('controls', { url: URL, target: view.target, composer });
        await page.waitForFunction(() => window.state().controls !== null);
        await picture();
        await page.evaluate(() => { window.order.length = 0; });
        await compareWith(composer ? 'post-processing' : 'controls');
        const order = await page.evaluate(() => window.order.slice(0, window.order.indexOf('render') + 1));
        assert.deepEqual(order.slice(0, 2), ['controls', 'halflight'], order.join());
        assert.equal(order.at(-1), 'render');
        assert.equal(order.filter((name) => name === 'halflight').length, 1, 'once a frame');
    }
    quiet();
});

test('react: useBakedObject() lights an object by the probes, and leaves it as it was', async () => {
    const { page } = await open();
    await clear();
    const ball = () => page.evaluate(() => {
        window.picture();
        const mesh = window.state().scene.getObjectByName('ball');
        const object = mesh && window.bake?.objects.find(({ meshes }) => meshes.includes(mesh));
        return { lit: Boolean(object), patched: mesh ? Object.hasOwn(mesh.material, 'onBeforeCompile') : null, objects: window.bake?.objects.length };
    });
    await show('hook', { url: URL });
    await page.evaluate(() => { window.bake = window.held.at(-1)[1]; });
    const own = (await ball()).objects;
    await show('ball of a hook', { url: URL, position: [0, 1, 0] });
    assert.deepEqual({ ...(await ball()), objects: 0 }, { lit: true, patched: true, objects: 0 });
    await show('ball', { url: URL, ball: true, position: [0, 1, 0] });
    assert.deepEqual({ ...(await ball()), objects: 0 }, { lit: true, patched: true, objects: 0 });
    const withBall = await picture();
    await show('ball', { url: URL, ball: false });
    await picture();
    assert.notEqual(await picture(), withBall);
    await show('hook', { url: URL });
    await picture();
    assert.equal((await ball()).objects, own, 'objects that were unmounted are forgotten');
    quiet();
    const { view } = opened;
    await page.evaluate((list) => window.show(...list), ['ball alone', {}, view, {}]);
    await page.waitForFunction('window.failed !== null');
    assert.match(await page.evaluate('window.failed'), /useBakedObject\(\) has no bake/);
});

test('react: Suspense shows a fallback first, and what another hides stays', async () => {
    const { page, requests } = await open();
    await clear();
    await page.route('**/lights.glb', async (route) => {
        await page.waitForFunction('window.sawFallback', null, { polling: 50 });
        await route.continue();
    });
    const seen = page.waitForFunction(() => window.state().scene.getObjectByName('fallback') !== undefined && (window.sawFallback = true), null, { polling: 20 });
    await Promise.all([show('own suspense', { url: URL }), seen]);
    await page.unroute('**/lights.glb');
    await compareWith('after its fallback');
    await show('slow', { url: URL });
    const before = requests.length;
    await page.evaluate(() => { window.slow = new Promise((resolve) => { window.goOn = resolve; }); });
    await Promise.all([
        show('slow', { url: URL, slow: true }),
        page.waitForFunction(() => window.state().scene.getObjectByName('fallback') !== undefined).then(() => page.waitForTimeout(500)).then(() => page.evaluate(() => window.goOn())),
    ]);
    assert.equal(requests.length, before, 'the file was not loaded again');
    await compareWith('after another');
    quiet();
});

test('react: unmounting frees the file, and it may be mounted again', async () => {
    const { page, requests } = await open();
    await clear();
    const before = await memory();
    const counts = [];
    for (let i = 0; i < 3; ++i) {
        requests.length = 0;
        await show('twice', { url: URL, positions: [[0, 0, 0], [50, 0, 0]] }, { models: 2 });
        await compareWith(`mounted ${i + 1} times`);
        const during = await memory();
        assert.ok(during.textures > before.textures && during.geometries > before.geometries, JSON.stringify({ before, during }));
        assert.equal(requests.length, 1, 'it was loaded again');
        await show('twice', { url: URL, positions: [[0, 0, 0]] });
        await page.waitForTimeout(50);
        await compareWith('one of two is left');
        await clear();
        await picture();
        counts.push(await memory());
    }
    assert.deepEqual(counts[1], counts[0]);
    assert.deepEqual(counts[2], counts[0]);
    // three.js keeps a texture of its own.
    assert.ok(counts[2].textures <= 1 && counts[2].geometries <= before.geometries, JSON.stringify({ before, counts }));
    quiet();
});

test('react: Draco and meshopt decoders', async () => {
    const { requests } = await open();
    await clear();
    halflight('optimize', studio.pathOf('lights'), studio.pathOf('meshopt'));
    const cli = [join(web, 'node_modules/.bin/gltf-transform'), 'draco', studio.pathOf('lights'), studio.pathOf('draco'), '--config', join(web, 'gltf-transform/halflight.config.mjs')];
    execFileSync(process.execPath, cli, { cwd: web, stdio: 'ignore' });
    for (const name of ['meshopt', 'draco']) {
        requests.length = 0;
        await show('decoded', { url: `/files/${name}.glb` });
        await compareWith(name, pictureOf(name, SIZE, '--mode', 'shadowmask', '--exposure', String(opened.exposure)).reference);
        assert.equal(requests.length, 1, 'options are compared by value');
        await clear();
    }
    quiet();
});

test("react: drei's useGLTF and <Gltf>", async () => { // the last: drei keeps the file
    const { page } = await open();
    await clear();
    await show('drei', { url: URL, position: [3, 1, -2] }, { offset: [3, 1, -2] });
    await compareWith("drei's Gltf");
    assert.deepEqual(await page.evaluate(() => [...window.bake.warnings]), []);
    quiet();
});
