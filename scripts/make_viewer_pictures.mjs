// Draws docs/images/viewer_desktop.jpg, viewer_phone.jpg and viewer_bake.webp: the viewer page in headless Chromium.
//
//   node scripts/make_viewer_pictures.mjs BAKED.glb [FOLDER]
//
// BAKED.glb is the courtyard, baked. It needs npm install in web/. For viewer_bake.webp the page bakes the courtyard
// itself, where scripts/build-wasm.sh has built the baker.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { launch, missing, newPage, serveFolder, web } from '../web/tests/harness.mjs';

const GAP = 20; // pixels between the two phones

const [baked, out = join(dirname(fileURLToPath(import.meta.url)), '../docs/images')] = process.argv.slice(2);
const reason = missing() ?? (baked ? null : 'usage: node scripts/make_viewer_pictures.mjs BAKED.glb [FOLDER]');
if (reason) {
    console.error(`make_viewer_pictures.mjs: ${reason}`);
    process.exit(2);
}

const folder = mkdtempSync(join(tmpdir(), 'halflight-viewer-'));
execFileSync(process.execPath, [join(web, 'scripts/build_viewer.mjs'), folder, baked]);
const server = await serveFolder(folder);
const browser = await launch();

/** The page at an address, with its whole picture. */
async function open(address, options) {
    const page = await newPage(browser, options);
    page.setDefaultTimeout(500000);
    await page.goto(`${server.url}/index.html${address}`);
    await drawn(page);
    return page;
}

const drawn = (page) =>
    page.waitForFunction(() => document.body.dataset.picture === 'whole' && document.body.dataset.frames > 1);

/** The courtyard, baked by the page, beside what it was. */
async function drawBake() {
    const page = await open('', { viewport: { width: 1100, height: 680 } });
    await page.setInputFiles('#open', join(web, '../assets/courtyard.glb'));
    await page.waitForSelector('#bakery:not([hidden])');
    await page.selectOption('#quality', 'preview');
    await page.click('#bake');
    await page.waitForSelector('#download:not([hidden])');
    await page.waitForFunction(() => document.querySelector('#file').textContent === 'courtyard-baked.glb');
    await drawn(page);
    await sharp(await page.screenshot()).webp({ quality: 80 }).toFile(join(out, 'viewer_bake.webp'));
}

const sharp = createRequire(join(web, 'package.json'))('sharp');
try {
    const desktop = await open('', { viewport: { width: 1100, height: 680 } });
    await sharp(await desktop.screenshot()).jpeg({ quality: 86 }).toFile(join(out, 'viewer_desktop.jpg'));
    await desktop.close();
    if (existsSync(join(folder, 'bake'))) await drawBake();
    const phone = await open('?panel=closed', { viewport: { width: 360, height: 720 }, hasTouch: true, isMobile: true });
    const closed = await phone.screenshot();
    await phone.tap('#panel summary');
    await phone.waitForTimeout(3000); // the picture is drawn anew
    const opened = await phone.screenshot();
    const { width, height } = await sharp(closed).metadata();
    const both = sharp({ create: { width: 2 * width + GAP, height, channels: 3, background: '#fff' } });
    const phones = [{ input: opened, left: 0, top: 0 }, { input: closed, left: width + GAP, top: 0 }];
    await both.composite(phones).jpeg({ quality: 86 }).toFile(join(out, 'viewer_phone.jpg'));
} finally {
    await browser.close();
    server.close();
    rmSync(folder, { recursive: true });
}
