// What moving objects cost update(), and what they cost another version of the plug-in, in one run:
//   node bench/moving.mjs BAKED.glb [FOLDER_OF_ANOTHER_PLUGIN] [OBJECTS] [FRAMES]
import { basename, dirname, resolve } from 'node:path';

import { launch, missing, newPage, serve } from '../tests/harness.mjs';

const [file, other, objects = '300', frames = '200'] = process.argv.slice(2);
const reason = missing() ?? (file ? null : 'usage: node bench/moving.mjs BAKED.glb [FOLDER_OF_ANOTHER_PLUGIN] [OBJECTS] [FRAMES]');
if (reason) {
    console.error(reason);
    process.exit(2);
}
const server = await serve(dirname(resolve(file)), 'three', other ? { '/other/': resolve(other) } : {});
const browser = await launch();
const page = await newPage(browser);
page.on('pageerror', (error) => console.error(String(error)));
await page.goto(`${server.url}/web/bench/moving.html`);
await page.waitForFunction('window.ready === true');
const folders = ['/web/three', ...(other ? ['/other'] : [])];
const results = await page.evaluate((options) => window.measure(options), { file: `/files/${basename(file)}`, objects: Number(objects), frames: Number(frames), folders });
console.log(`| plug-in | update() ms, ${objects} of ${objects} move | a tenth of them |\n|---|---|---|`);
for (const [i, name] of ['this one', other].slice(0, results.length).entries()) console.log(`| ${name} | ${results[i].all.toFixed(2)} | ${results[i].few.toFixed(2)} |`);
if (other) console.log(`ratio ${(results[0].all / results[1].all).toFixed(3)}, of a tenth ${(results[0].few / results[1].few).toFixed(3)}`);
await browser.close();
server.close();
