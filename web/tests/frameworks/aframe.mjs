// The component halflight-model: its properties, its life, and the sentence about a second three.js.
import assert from 'node:assert/strict';
import { copyFileSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { repository, serveFolder } from '../harness.mjs';
import { studio } from '../browser/studio.mjs';
import { compare, makeWorkspace, pictureOf } from './workspace.mjs';

const SIZE = { width: 320, height: 180 };
let folder = null;
let close = null; // of the page that is open: a test that fails leaves it
after(() => close?.());

/** The example's page with another file, another import map, and no frames but those that a test draws. */
async function open(change) {
    if (!folder) {
        folder = join(makeWorkspace('aframe'), 'aframe');
        copyFileSync(join(repository, 'assets/conformance/five_lights.glb'), studio.pathOf('lights'));
        copyFileSync(studio.pathOf('lights'), join(folder, 'lights.glb'));
    }
    writeFileSync(join(folder, 'test.html'), change(readFileSync(join(folder, 'index.html'), 'utf8').replace('courtyard-baked.glb', 'lights.glb')));
    const server = await serveFolder(folder);
    const page = await studio.newPage({ viewport: SIZE });
    const trouble = [];
    page.on('pageerror', (error) => trouble.push(String(error)));
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && !/Failed to load resource|GPU stall|Clock/.test(message.text()) && trouble.push(message.text()));
    await page.goto(`${server.url}/test.html`);
    close = () => page.close().then(() => server.close());
    return { page, trouble, close };
}

/** Draws through the program's camera. Runs in a page. */
function draw({ fov, eye, target }) {
    const { sceneEl } = document.querySelector('a-camera');
    const { object3D, renderer } = sceneEl;
    renderer.setAnimationLoop(null);
    const camera = new AFRAME.THREE.PerspectiveCamera(fov, 16 / 9, 0.05, 200);
    camera.position.fromArray(eye);
    camera.lookAt(new AFRAME.THREE.Vector3(...target));
    sceneEl.camera = camera;
    sceneEl.tick(performance.now(), 16);
    renderer.render(object3D, camera);
    return renderer.domElement.toDataURL('image/png').split(',')[1];
}

test('A-Frame: modes, places, events, and what is removed is freed', async () => {
    const { page, trouble, close } = await open((text) => text.replace('<script type="module">', `<script>
    HTMLCanvasElement.prototype.getContext = ((get) => function (kind, options) { return get.call(this, kind, { ...options, antialias: false }); })(HTMLCanvasElement.prototype.getContext);
    window.loaded = new Promise((resolve) => document.addEventListener('model-loaded', (event) => resolve(event.detail), { once: true }));
</script>
<script type="module">`));
    const same = await page.evaluate(async () => {
        const { gltf, model, halflight } = await window.loaded;
        window.entity = document.querySelector('[halflight-model]');
        return gltf.scene === model && window.entity.components['halflight-model'].halflight === halflight && halflight.mode === 'shadowmask';
    });
    assert.ok(same, 'the event has what the component has');
    for (const mode of ['shadowmask', 'realtime']) {
        const { reference, camera, exposure } = pictureOf('lights', SIZE, '--mode', mode);
        const view = { fov: camera.verticalFovDegrees, eye: camera.eye, target: camera.target };
        await page.evaluate(([name, ev]) => {
            window.entity.setAttribute('halflight-model', 'mode', name);
            window.entity.sceneEl.renderer.toneMappingExposure = 2 ** -ev;
        }, [mode, exposure]);
        await compare(page, `A-Frame, ${mode}`, await page.evaluate(draw, view), reference);
        const at = { ...view, eye: view.eye.map((x, i) => x + [4, 1, -3][i]), target: view.target.map((x, i) => x + [4, 1, -3][i]) };
        await page.evaluate(() => window.entity.setAttribute('position', '4 1 -3'));
        await compare(page, `A-Frame, ${mode}, moved`, await page.evaluate(draw, at), reference);
        await page.evaluate(() => window.entity.setAttribute('position', '0 0 0'));
    }
    const lights = await page.evaluate(() => document.querySelectorAll('[light]').length);
    assert.equal(lights, 0, "A-Frame's default lights are off");
    const counts = await page.evaluate(async () => {
        const { memory } = window.entity.sceneEl.renderer.info;
        const during = { ...memory };
        window.entity.remove();
        await new Promise((resolve) => setTimeout(resolve, 100));
        return { during, after: { ...memory }, models: AFRAME.scenes[0].systems['halflight-model'].models.size };
    });
    console.log(`A-Frame, removed: ${JSON.stringify(counts)}`);
    assert.equal(counts.models, 0);
    assert.ok(counts.during.textures > 5 && counts.after.textures <= 1 && counts.after.geometries <= 1, JSON.stringify(counts));
    assert.deepEqual(trouble, []);
    await close();
});

test('A-Frame: a file that cannot be loaded is an event and a sentence', async () => {
    const { page, trouble, close } = await open((text) => text.replace('lights.glb', 'none.glb'));
    await page.waitForFunction(() => document.querySelector('a-scene')?.hasLoaded);
    const deadline = Date.now() + 60000;
    while (trouble.length === 0 && Date.now() < deadline) await page.waitForTimeout(100);
    assert.match(trouble[0] ?? '', /Halflight: none\.glb: /);
    await close();
});

test('A-Frame: a second three.js is refused with a sentence', async () => {
    // A-Frame's other build has three.js within, and is a global.
    const bundled = '<script src="./node_modules/aframe/dist/aframe-master.min.js"></script>\n<script type="importmap">';
    const { trouble, page, close } = await open((text) => text.replace('<script type="importmap">', bundled).replace('./node_modules/aframe/dist/aframe-master.module.min.js', 'data:text/javascript,export default AFRAME'));
    const deadline = Date.now() + 60000;
    while (!trouble.some((sentence) => /Halflight/.test(sentence)) && Date.now() < deadline) await page.waitForTimeout(100);
    await close();
    assert.match(trouble.join('\n'), /Halflight: A-Frame has a three\.js of its own/);
});
