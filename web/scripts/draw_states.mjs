// Draws a baked file in states of its light groups by three.js in headless Chromium: scripts/measure_chapel.py.
//
//   node web/scripts/draw_states.mjs BAKED.glb STATES.json OUT --camera NAME --size 160x90 [--supersampling 4] [--renderer webgl]
//
// STATES.json has weights by group by state: {"dusk": {"sun": [0, 0, 0]}}. Each state's picture is OUT/STATE.f32: linear radiance in
// cd/m2, three floats a pixel, rows from the top, each pixel the mean of its samples. Renderers: webgl, webgpu, webgl2-nodes. Where
// no browser or package is, one sentence says so, and the exit code is 3.
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';

import { launch, missing, openPage, serve } from '../tests/harness.mjs';

const { values, positionals } = parseArgs({
    allowPositionals: true,
    options: { camera: { type: 'string' }, size: { type: 'string' }, supersampling: { type: 'string', default: '4' }, renderer: { type: 'string', default: 'webgl' } },
});
const [baked, states, out] = positionals;
if (!out || !values.camera || !/^\d+x\d+$/.test(values.size ?? '')) {
    console.error('usage: node web/scripts/draw_states.mjs BAKED.glb STATES.json OUT --camera NAME --size WIDTHxHEIGHT');
    process.exit(2);
}
const reason = missing({ program: false });
if (reason) {
    console.error(`draw_states.mjs: three.js is not drawn: ${reason}`);
    process.exit(3);
}

/** In the page: weights, then the frame, when all light has them. @returns base64 of the picture's floats, each pixel the mean of its samples */
async function drawState({ weights, camera, width, height, side }) {
    const { loaded, makeRenderer, viewOf, draw } = window.halflightPage;
    const { halflight } = loaded;
    for (const { name, savedWeight } of halflight.lightGroups) halflight.setLightGroup(name, weights[name] ?? savedWeight);
    const renderer = await makeRenderer(width * side, height * side);
    for (halflight.update(renderer, viewOf(camera, width / height)); halflight.isFollowing; ) halflight.update(renderer, viewOf(camera, width / height));
    const { warnings } = await draw({ width: width * side, height: height * side, camera, settings: { mode: 'shadowmask' } });
    const { rows } = loaded.picture;
    const means = new Float32Array(width * height * 3);
    for (let y = 0; y < height * side; ++y)
        for (let x = 0; x < width * side; ++x)
            for (let c = 0; c < 3; ++c) means[3 * (Math.floor(y / side) * width + Math.floor(x / side)) + c] += rows[3 * (y * width * side + x) + c] / side ** 2;
    const bytes = new Uint8Array(means.buffer);
    let text = '';
    for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
    return { warnings, pixels: btoa(text) };
}

const folder = mkdtempSync(join(tmpdir(), 'halflight-states-'));
copyFileSync(baked, join(folder, 'baked.glb'));
mkdirSync(out, { recursive: true });
const server = await serve(folder);
const browser = await launch();
try {
    const { page, call } = await openPage(browser, server.url, values.renderer);
    await call('load', { file: '/files/baked.glb' });
    const [width, height] = values.size.split('x').map(Number);
    for (const [state, weights] of Object.entries(JSON.parse(readFileSync(states)))) {
        const { warnings, pixels } = await page.evaluate(drawState, { weights, camera: values.camera, width, height, side: Number(values.supersampling) });
        for (const warning of warnings) console.error(`${state}: ${warning}`);
        writeFileSync(join(out, `${state}.f32`), Buffer.from(pixels, 'base64'));
    }
} finally {
    await browser.close();
    server.close();
    rmSync(folder, { recursive: true });
}
