// The viewer's folder, served as it stands: it opens the showcase, follows a link, and says what is wrong with other files.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import { halflight, launch, missing, repository, serveFolder, web } from './harness.mjs';

const reason = missing();
if (reason) {
    console.log(`[  SKIPPED ] web.viewer: ${reason}`);
    process.exit(0);
}

test('the viewer works from its own folder', async () => {
    const folder = mkdtempSync(join(tmpdir(), 'halflight-viewer-'));
    const showcase = join(folder, 'baked.glb');
    halflight('bake', join(repository, 'assets/tests/five_lights.glb'), '-o', showcase, '--quality', 'preview', '-q');
    execFileSync(process.execPath, [join(web, 'scripts/build_viewer.mjs'), join(folder, 'viewer'), showcase]);
    writeFileSync(join(folder, 'viewer/plain.glb'), 'not glTF');
    const server = await serveFolder(join(folder, 'viewer'));
    const browser = await launch();
    try {
        const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
        const errors = [];
        page.on('pageerror', (error) => errors.push(String(error)));
        page.on('request', (request) => {
            const own = request.url().startsWith(server.url) || /^(data|blob):/.test(request.url());
            if (!own) errors.push(`asks for ${request.url()}`);
        });
        await page.goto(`${server.url}/index.html#mode=distance-shadowmask&distance=20`);
        const drawn = (n) => page.waitForFunction((frames) => Number(document.body.dataset.frames) >= frames, n, { timeout: 60000 });
        await drawn(1);
        const state = await page.evaluate(() => ({
            mode: document.querySelector('#modes input:checked').value,
            distance: document.querySelector('#distanceValue').textContent,
            lights: [...document.querySelectorAll('#lights label')].map((l) => l.querySelector('input').disabled),
            statistics: document.querySelector('#statistics').textContent,
        }));
        assert.equal(state.mode, 'distance-shadowmask');
        assert.equal(state.distance, '20 m');
        assert.equal(state.lights.filter((disabled) => disabled).length, 1, 'the fully baked light cannot be switched');
        assert.match(state.statistics, /draw calls[1-9]/);
        await page.click('#modes input[value=shadowmask]');
        await drawn(2);
        await page.setInputFiles('#open', join(folder, 'viewer/plain.glb'));
        await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('plain.glb: '));
        assert.deepEqual(errors, []);
    } finally {
        await browser.close();
        server.close();
        rmSync(folder, { recursive: true });
    }
});
