// Opens pages of the site in headless Chromium and takes pictures: node scripts/site/open_pages.mjs SITE PICTURES
// Fails if a page asks for anything outside the site, if something of the site is missing, or if a script has an error.
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';

import { launch, newPage, serveFolder } from '../../web/tests/harness.mjs';

const pages = {
    start: 'index.html',
    guide: 'docs/guide/lights-and-objects.html',
    guide_table: 'docs/format.html',
    api: 'api/law_8h.html',
    api_class: 'api/structhalflight_1_1BakeSettings.html',
    viewer: 'viewer/index.html',
};

const [site, pictures] = process.argv.slice(2);
mkdirSync(pictures, { recursive: true });
const server = await serveFolder(site);
const browser = await launch();
const faults = [];
for (const [name, path] of Object.entries(pages)) {
    const page = await newPage(browser, { viewport: { width: 1280, height: 800 } });
    let requests = 0;
    page.on('request', (request) => {
        requests++;
        const url = request.url();
        if (!url.startsWith(server.url) && !/^(data|blob):/.test(url)) faults.push(`${path} asks for ${url}`);
    });
    page.on('response', (response) => {
        const url = response.url();
        if (response.status() >= 400 && !url.endsWith('/favicon.ico')) faults.push(`${path}: ${url} is missing`);
    });
    page.on('pageerror', (error) => faults.push(`${path}: ${error}`));
    await page.goto(`${server.url}/${path}`, { waitUntil: 'networkidle' });
    if (name === 'viewer') {
        await page.waitForSelector('#controls:not([hidden])');
        await page.waitForTimeout(20000); // the whole picture follows the first one; SwiftShader is slow
    }
    await page.screenshot({ path: join(pictures, `${name}.png`) });
    console.log(`${path}: ${requests} requests`);
    await page.close();
}
await browser.close();
server.close();
for (const fault of faults) console.error(fault);
process.exit(faults.length > 0 ? 1 : 0);
