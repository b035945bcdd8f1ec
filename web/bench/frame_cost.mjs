// The plug-in's frame against three.js alone with the same lights and shadow maps, in one run:
//   node bench/frame_cost.mjs BAKED.glb [WIDTHxHEIGHT] [FRAMES]
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join, resolve } from 'node:path';

import { halflight, launch, missing, openPage, serve } from '../tests/harness.mjs';

const [file, size = '480x270', frames = '7'] = process.argv.slice(2);
const reason = missing() ?? (file ? null : 'usage: node bench/frame_cost.mjs BAKED.glb [WIDTHxHEIGHT] [FRAMES]');
if (reason) {
    console.error(reason);
    process.exit(2);
}
const [width, height] = size.split('x').map(Number);
const folder = mkdtempSync(join(tmpdir(), 'halflight-cost-'));
const { camera } = JSON.parse(halflight('render', file, '-o', join(folder, 'view.exr'), '--size', '32x18', '--json'));
rmSync(folder, { recursive: true });
const server = await serve(dirname(resolve(file)));
const browser = await launch();
const { call } = await openPage(browser, server.url);
const view = { fov: camera.verticalFovDegrees, eye: camera.eye, target: camera.target };
console.log('| drawn by | frame ms | of it update() ms | draw calls | triangles |\n|---|---|---|---|---|');
for (const mode of ['three.js', 'realtime', 'distance-shadowmask', 'shadowmask']) {
    const r = await call('frameCost', { file: `/files/${basename(file)}`, width, height, camera: view, mode, frames: Number(frames) });
    console.log(`| ${mode} | ${r.frame.toFixed(0)} | ${r.update.toFixed(1)} | ${r.calls} | ${r.triangles} |`);
}
await browser.close();
server.close();
