// Time to the first picture of a viewer page, and of another version of it, in one run:
//   node bench/first_picture.mjs VIEWER [OTHER_VIEWER] [--file NAME] [--size WxH] [--runs N]
// VIEWER and OTHER_VIEWER are folders that build_viewer.mjs made, of two revisions. Each run has a browser of its own, so
// that no cache helps.
import { parseArgs } from 'node:util';

import { launch, missing, newPage, serveFolder } from '../tests/harness.mjs';

const { values, positionals } = parseArgs({
    allowPositionals: true,
    options: {
        file: { type: 'string', default: '' },
        size: { type: 'string', default: '1280x720' },
        runs: { type: 'string', default: '3' },
    },
});
const usage = 'usage: node bench/first_picture.mjs VIEWER [OTHER_VIEWER] [--file NAME] [--size WxH] [--runs N]';
const reason = missing() ?? (positionals.length > 0 ? null : usage);
if (reason) {
    console.error(reason);
    process.exit(2);
}
const [width, height] = values.size.split('x').map(Number);

/** Runs in the page, before its scripts: stops the time when a frame is drawn, that is when its pixels can be read. */
function stopTheTime() {
    addEventListener('DOMContentLoaded', () => {
        new MutationObserver(() => {
            const gl = document.querySelector('canvas').getContext('webgl2');
            gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
            (window.frameTimes ??= []).push(performance.timeOrigin + performance.now());
        }).observe(document.body, { attributes: true, attributeFilter: ['data-frames'] });
    });
}

/**
 * Milliseconds from the request of the page to its first frame, and bytes that came over the network. A page with the
 * baker loads itself again, which counts.
 */
async function measure(folder) {
    const server = await serveFolder(folder);
    const browser = await launch();
    const page = await newPage(browser, { viewport: { width, height } });
    const bodies = [];
    const sizeOf = (response) => response.body().then((body) => body.length, () => 0);
    page.on('response', (response) => bodies.push(sizeOf(response)));
    page.on('pageerror', (error) => console.error(String(error)));
    await page.addInitScript(stopTheTime);
    const start = Date.now();
    await page.goto(`${server.url}/index.html${values.file ? `?file=${values.file}` : ''}`);
    await page.waitForFunction('window.frameTimes?.length > 0');
    const milliseconds = (await page.evaluate('window.frameTimes[0]')) - start;
    const bytes = (await Promise.all(bodies)).reduce((sum, length) => sum + length, 0);
    await browser.close();
    server.close();
    return { milliseconds, bytes };
}

const median = (list) => list.sort((a, b) => a - b)[Math.floor(list.length / 2)];
const results = positionals.map(() => []);
for (let run = 0; run < Number(values.runs); ++run)
    for (const [i, folder] of positionals.entries()) results[i].push(await measure(folder));
console.log(`| viewer, ${values.size} | first picture ms, median of ${values.runs} | MB |\n|---|---|---|`);
const medians = results.map((list) => median(list.map((r) => r.milliseconds)));
for (const [i, folder] of positionals.entries())
    console.log(`| ${folder} | ${medians[i].toFixed(0)} | ${(results[i][0].bytes / 1e6).toFixed(2)} |`);
if (medians.length > 1) console.log(`ratio ${(medians[0] / medians[1]).toFixed(3)}`);
