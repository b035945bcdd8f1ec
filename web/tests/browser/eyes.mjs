// One update() serves all cameras of a frame, as the eyes of a headset: each shows what it shows alone.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { studio } from './studio.mjs';

/** Draws two eyes far apart by one ArrayCamera, and each alone. Runs in the page. */
async function drawEyes({ file, settings, headset }) {
    const { THREE, loaded, load, makeRenderer, viewOf, readPixels } = window.halflightPage;
    await load({ file });
    const r = await makeRenderer(320, 180);
    const { scene, halflight } = loaded;
    Object.assign(halflight, settings);
    const [width, height] = [96, 54];
    const eyes = [[-1, 0, 0], [1, 0, -25]].map((place, i) => {
        const eye = viewOf('main', width / height);
        eye.position.add(new THREE.Vector3(...place));
        eye.updateMatrixWorld();
        eye.matrixWorldInverse.copy(eye.matrixWorld).invert();
        eye.viewport = new THREE.Vector4(i * width, 0, width, height);
        return eye;
    });
    const both = new THREE.ArrayCamera(eyes);
    both.copy(viewOf('main', width / height), false);
    both.cameras = eyes;
    scene.traverse((object) => { object.frustumCulled = false; }); // its own frustum lacks what an eye sees
    const target = new (THREE.WebGLRenderTarget ?? THREE.RenderTarget)(2 * width, height, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
    const draw = async (camera, update) => {
        update();
        r.setRenderTarget(target);
        r.render(scene, camera);
        const pixels = await readPixels(r, target, 2 * width, height);
        r.setRenderTarget(null);
        return pixels;
    };
    // A headset's camera is three.js's own: update() gets the application's, and takes that.
    const { xr } = r;
    const inHeadset = () => {
        const kept = { enabled: xr.enabled, isPresenting: xr.isPresenting, getCamera: xr.getCamera, updateCamera: xr.updateCamera };
        let posed = 0;
        Object.assign(xr, { enabled: true, isPresenting: true, getCamera: () => both, updateCamera: () => { posed += 1; } });
        halflight.update(r, new THREE.PerspectiveCamera());
        Object.assign(xr, kept);
        if (posed !== 1) throw new Error(`the pose was asked for ${posed} times`);
    };
    const together = await draw(both, headset ? inHeadset : () => halflight.update(r, both));
    const alone = [];
    for (const eye of eyes) {
        const { viewport } = eye;
        const one = new THREE.ArrayCamera([eye]); // the same place in the target
        one.copy(eye, false);
        one.cameras = [eye];
        alone.push(await draw(one, () => halflight.update(r, eye)));
        eye.viewport = viewport;
    }
    target.dispose();
    const encode = (x) => 255 * Math.min(Math.max(x * settings.exposure, 0), 1) ** (1 / 2.2);
    return eyes.map((_, eye) => {
        let sum = 0;
        let near = 0;
        let light = 0;
        for (let y = 0; y < height; ++y)
            for (let x = eye * width; x < (eye + 1) * width; ++x) {
                const at = 4 * (y * 2 * width + x);
                const d = [0, 1, 2].map((c) => Math.abs(encode(together[at + c]) - encode(alone[eye][at + c])));
                sum += (d[0] + d[1] + d[2]) / 3;
                light += encode(alone[eye][at + 1]);
                if (Math.max(...d) <= 1) near += 1;
            }
        const count = width * height;
        return { mean: sum / count, near: near / count, light: light / count };
    });
}

for (const renderer of ['webgl', 'webgpu']) {
    test(`eyes: one update() for two cameras, ${renderer}`, async () => {
        const { page } = await studio.pageOf('three', renderer);
        for (const headset of [false, true]) {
            const settings = { mode: 'realtime', shadowDistance: 14, shadowFadeRange: 3, exposure: 0.3 };
            const eyes = await page.evaluate(drawEyes, { file: '/assets/conformance/avenue.glb', settings, headset });
            console.log(`${renderer}, ${headset ? 'headset' : 'ArrayCamera'}: ${eyes.map(({ mean, near, light }) => `${mean.toFixed(3)} of 255 apart, ${(100 * near).toFixed(2)} % within 1, mean ${light.toFixed(0)}`).join('; ')}`);
            for (const { mean, near, light } of eyes) {
                assert.ok(light > 20 && light < 235, `there is a picture: ${light}`);
                assert.ok(mean <= 0.2 && near >= 0.985, `${mean} of 255, ${near} within 1`);
            }
        }
    });
}
