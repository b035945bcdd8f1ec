// bake() of @halflight/bake in headless Chromium: as Vite builds the page of the README, and what a page must have.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, cpSync, existsSync, mkdirSync, readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { after, before, test } from 'node:test';

import { launch, newPage, web } from '../harness.mjs';
import { halflight, hash, hashOf, scene, workspace } from './workspace.mjs';

const vite = join(web, 'examples/node_modules/vite/bin/vite.js');
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm' };
const ISOLATED = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };
const closing = [];
let browser;
before(async () => (browser = await launch()));
after(async () => {
    await browser.close();
    closing.forEach((server) => server.close());
});

/** Serves a folder; the address. */
async function serve(folder, headers = ISOLATED) {
    const server = createServer((request, response) => {
        const path = join(folder, decodeURIComponent(new URL(request.url, 'http://localhost').pathname).replace(/\/$/, '/index.html'));
        if (!existsSync(path)) return void response.writeHead(404).end();
        response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'application/octet-stream', ...headers }).end(readFileSync(path));
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
    closing.push(server);
    return `http://127.0.0.1:${server.address().port}/`;
}

/** A page without a bundler: the package as npm installed it, and what a test calls. */
function plainPage() {
    const folder = join(workspace(), 'plain');
    if (existsSync(folder)) return folder;
    cpSync(join(workspace(), 'node_modules/@halflight/bake'), join(folder, 'bake'), { recursive: true });
    copyFileSync(join(folder, 'bake/src/isolate.js'), join(folder, 'isolate.js'));
    copyFileSync(scene('sphere_on_floor'), join(folder, 'scene.glb'));
    const page = (before) => `<!doctype html><meta charset="utf-8">${before}
<script type="importmap">{ "imports": { "#worker": "./bake/src/worker_web.js" } }</script>
<script type="module">
import { bake } from './bake/src/index.js';
const bytes = new Uint8Array(await (await fetch('scene.glb')).arrayBuffer());
const hex = async (data) => [...new Uint8Array(await crypto.subtle.digest('SHA-256', data))].map((b) => b.toString(16).padStart(2, '0')).join('');
window.run = async (options, cancel) => {
    const control = new AbortController();
    let calls = 0;
    const onProgress = () => ++calls && cancel && control.abort();
    try {
        const { glb, report } = await bake(bytes, { ...options, onProgress, signal: control.signal });
        return { hash: await hex(glb), charts: report.lightmap.charts, calls };
    } catch (error) {
        return { name: error.name, message: error.message };
    }
};
window.ready = true;
</script>`;
    writeFileSync(join(folder, 'index.html'), page(''));
    writeFileSync(join(folder, 'isolated.html'), page('<script src="isolate.js"></script>'));
    return folder;
}

async function open(url) {
    const page = await newPage(browser);
    const errors = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
    await page.goto(url);
    await page.waitForFunction('window.ready === true').catch((error) => {
        throw new Error(`${error}\n${errors.join('\n')}`);
    });
    return { page, run: (options, cancel) => page.evaluate(([o, c]) => window.run(o, c), [options, cancel]) };
}

function hashInNode() {
    const file = join(workspace(), 'node.glb');
    const { status, stderr } = halflight(['bake', scene('sphere_on_floor'), '-o', file, '--quality', 'preview', '-q']);
    assert.equal(status, 0, stderr);
    return hashOf(file);
}

test('Chromium gives the bytes of Node, twice on one page, and cancels', async () => {
    const { page, run } = await open(await serve(plainPage()));
    const first = await run({ quality: 'preview' });
    assert.equal(first.hash, hashInNode(), JSON.stringify(first));
    assert.ok(first.calls > 5 && first.charts > 0);
    assert.equal((await run({ quality: 'ultra' }, true)).name, 'AbortError');
    assert.equal((await run({ quality: 'preview', threads: 1 })).hash, first.hash);
    assert.match((await run({ quality: 'best' })).message, /^--quality: must be one of/);
    await page.close();
});

test('a page that is not isolated gets a sentence; isolate.js makes it one', async () => {
    const url = await serve(plainPage(), {});
    const { page, run } = await open(url);
    const { name, message } = await run({});
    assert.equal(name, 'BakeError');
    assert.match(message, /Cross-Origin-Opener-Policy: same-origin.*Cross-Origin-Embedder-Policy: require-corp.*isolate\.js/);
    await page.close();
    const isolated = await newPage(browser);
    await isolated.goto(`${url}isolated.html`);
    await isolated.waitForFunction('window.ready === true && crossOriginIsolated');
    assert.ok((await isolated.evaluate(() => window.run({ quality: 'preview' }))).hash);
    await isolated.close();
});

test('the page of the README, as Vite builds it', { skip: !existsSync(vite) && 'no Vite: npm ci in web/examples' }, async () => {
    const folder = join(workspace(), 'page');
    mkdirSync(folder, { recursive: true });
    const [config, script] = [...readFileSync(join(web, 'bake/README.md'), 'utf8').matchAll(/```js\n([\s\S]*?)```/g)].map(([, code]) => code).slice(1);
    symlinkSync(join(web, 'examples/node_modules/vite'), join(workspace(), 'node_modules/vite'));
    writeFileSync(join(folder, 'vite.config.js'), config);
    writeFileSync(join(folder, 'main.js'), script);
    writeFileSync(join(folder, 'index.html'), '<!doctype html><input type="file"><progress max="100"></progress><script type="module" src="main.js"></script>');
    execFileSync(process.execPath, [vite, 'build'], { cwd: folder, stdio: ['ignore', 'ignore', 'inherit'] });
    const page = await newPage(browser);
    await page.goto(await serve(join(folder, 'dist')));
    await page.setInputFiles('input', scene('sphere_on_floor'));
    await page.waitForSelector('a[download]');
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('a[download]')]);
    assert.equal(hash(readFileSync(await download.path())), hashInNode());
    await page.close();
});
