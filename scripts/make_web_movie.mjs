// Draws docs/images/viewer.webp: the viewer page in headless Chromium, its camera moving, its modes and views switching.
//
//   node scripts/make_web_movie.mjs BAKED.glb [OUT.webp] [--keep DIR]
//
// BAKED.glb is the courtyard, baked. --keep writes the frames as PNG too. It needs npm install in web/.
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { launch, missing, serveFolder, web } from '../web/tests/harness.mjs';

const WINDOW = { width: 960, height: 540 };
const WIDTH = 720; // of the picture
const MILLISECONDS = 100; // of a frame
const SHOTS = [
    ['mode=realtime&view=lit', 11],
    ['mode=baked-indirect&view=lit', 11],
    ['mode=shadowmask&view=lit', 11],
    ['mode=distance-shadowmask&view=lit&distance=14&fade=4', 7],
    ['mode=shadowmask&view=lightmap', 7],
    ['mode=shadowmask&view=shadowmask', 7],
];
const EYE = [-6.9, 1.85, 4.0];
const FORWARD = [0.732, -0.03, -0.681];

const positional = process.argv.slice(2).filter((a, i, all) => a !== '--keep' && all[i - 1] !== '--keep');
const keep = process.argv.includes('--keep') ? process.argv[process.argv.indexOf('--keep') + 1] : null;
const [baked, out = join(dirname(fileURLToPath(import.meta.url)), '../docs/images/viewer.webp')] = positional;
const reason = missing() ?? (baked ? null : 'usage: node scripts/make_web_movie.mjs BAKED.glb [OUT.webp] [--keep DIR]');
if (reason) {
    console.error(`make_web_movie.mjs: ${reason}`);
    process.exit(2);
}

/** Where the camera stands in frame i of n, on a closed curve, so that the movie has no beginning. */
function viewOf(i, n) {
    const angle = (2 * Math.PI * i) / n;
    const [side, ahead] = [1.1 * Math.sin(angle), 0.7 * (1 - Math.cos(angle))];
    const right = [-FORWARD[2], 0, FORWARD[0]];
    const eye = EYE.map((x, axis) => x + side * right[axis] + ahead * FORWARD[axis]);
    const target = EYE.map((x, axis) => x + 9 * FORWARD[axis]);
    return `eye=${eye.map((x) => x.toFixed(3))}&target=${target.map((x) => x.toFixed(3))}`;
}

const folder = mkdtempSync(join(tmpdir(), 'halflight-movie-'));
execFileSync(process.execPath, [join(web, 'scripts/build_viewer.mjs'), folder, baked, '--no-baker']);
const server = await serveFolder(folder);
const browser = await launch();
const frames = SHOTS.flatMap(([shot, count]) => new Array(count).fill(shot));
const pictures = [];
if (keep) mkdirSync(keep, { recursive: true });
try {
    const page = await browser.newPage({ viewport: WINDOW });
    const drawn = () => page.evaluate(() => Number(document.body.dataset.frames ?? 0));
    await page.goto(`${server.url}/index.html#${frames[0]}`);
    await page.waitForFunction(() => document.body.dataset.picture === 'whole' && document.body.dataset.frames > 1, null, { timeout: 300000 });
    for (const [i, shot] of frames.entries()) {
        const before = await drawn();
        await page.evaluate((hash) => (location.hash = hash), `${shot}&${viewOf(i, frames.length)}&distance=60&fade=1`);
        await page.waitForFunction((n) => Number(document.body.dataset.frames) > n, before, { timeout: 300000 });
        const png = await page.screenshot({ timeout: 300000 });
        pictures.push(png);
        if (keep) writeFileSync(join(keep, `frame${String(i).padStart(2, '0')}.png`), png);
    }
} finally {
    await browser.close();
    server.close();
    rmSync(folder, { recursive: true });
}

const sharp = createRequire(join(web, 'package.json'))('sharp');
const height = Math.round((WIDTH * WINDOW.height) / WINDOW.width);
const raw = await Promise.all(pictures.map((png) => sharp(png).removeAlpha().resize(WIDTH, height).raw().toBuffer()));
const stacked = sharp(Buffer.concat(raw), { limitInputPixels: false, raw: { width: WIDTH, height: height * raw.length, channels: 3, pageHeight: height } });
const { size } = await stacked.webp({ quality: 74, effort: 5, minSize: true, loop: 0, delay: raw.map(() => MILLISECONDS) }).toFile(out);
console.log(`${out}: ${raw.length} frames, ${(size / 1e6).toFixed(2)} MB`);
