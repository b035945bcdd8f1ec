// Frames in which the weight of a light group changes, beside frames in which none does, in one run:
//   node bench/light_groups.mjs BAKED.glb [WIDTHxHEIGHT] [CHANGES]
// Exits with 1 where a frame with a change takes longer than two of those without, by their median.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join, resolve } from 'node:path';

import { halflight, launch, missing, newPage, serve } from '../tests/harness.mjs';

const MOST = 2; // normal frames that a frame with a change may take

const [file, size = '960x540', changes = '15'] = process.argv.slice(2);
const reason = missing() ?? (file ? null : 'usage: node bench/light_groups.mjs BAKED.glb [WIDTHxHEIGHT] [CHANGES]');
if (reason) {
    console.error(reason);
    process.exit(2);
}
const [width, height] = size.split('x').map(Number);
const folder = mkdtempSync(join(tmpdir(), 'halflight-groups-'));
const { camera } = JSON.parse(halflight('render', file, '-o', join(folder, 'view.exr'), '--size', '32x18', '--json'));
rmSync(folder, { recursive: true });
const server = await serve(dirname(resolve(file)));
const browser = await launch();
const page = await newPage(browser);
page.on('pageerror', (error) => console.error(String(error)));
await page.goto(`${server.url}/web/bench/light_groups.html`);
await page.waitForFunction('window.ready === true');
const view = { fov: camera.verticalFovDegrees, eye: camera.eye, target: camera.target };
let failed = false;
for (const all of [false, true]) {
    const result = await page.evaluate((options) => window.measure(options), { file: `/files/${basename(file)}`, width, height, camera: view, changes: Number(changes), all });
    const { groups, pages, plain, changed, following } = result;
    console.log(`${groups} groups, ${pages} texels; ${all ? 'all' : 'one'} changed at once\n| frame | frames | median ms | most ms | of it update() ms |\n|---|---|---|---|---|`);
    for (const [name, row] of Object.entries({ 'without a change': plain, 'with a change': changed, 'that follow': following }))
        if (row) console.log(`| ${name} | ${row.frames} | ${row.median.toFixed(1)} | ${row.most.toFixed(1)} | ${row.update.toFixed(1)} |`);
    const longest = Math.max(changed.most, following?.most ?? 0) / plain.median;
    console.log(`the median takes ${(changed.median / plain.median).toFixed(2)} frames without a change, the longest ${longest.toFixed(2)}\n`);
    failed ||= longest > MOST;
}
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
