// The page of docs/web.md as it stands there, with the package as npm packs it: it looks like the program's picture.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { halflight, repository, serve, web } from '../harness.mjs';
import { differenceOf } from '../png.mjs';
import { studio } from './studio.mjs';

const SIZE = { width: 480, height: 270 };
const look = process.env.HALFLIGHT_WEB_PICTURES;

/** The first block of a language in a document, or below a heading. */
function blockOf(text, language, heading = '') {
    return text.slice(text.indexOf(heading)).match(new RegExp(`^\`\`\`${language}\\n([\\s\\S]*?)^\`\`\``, 'm'))[1];
}

test('documents: blocks for frameworks are the examples, which nightly tests run', () => {
    const text = readFileSync(join(repository, 'docs/web.md'), 'utf8');
    const blocks = [['React', 'jsx', 'react/App.jsx'], ['A-Frame', 'html', 'aframe/index.html'], ['threlte', 'svelte', 'threlte/Model.svelte'], ['tres', 'vue', 'tres/Model.vue']];
    for (const [heading, language, path] of blocks) assert.equal(blockOf(text, language, `\n## ${heading}\n`), readFileSync(join(web, 'examples', path), 'utf8'), path);
});

const npm = spawnSync('npm', ['--version']);
test('documents: the page without a bundler', { skip: npm.error ? 'npm not found' : false }, async () => {
    studio.bake('courtyard', 'courtyard', '--lightmap-size', '256');
    const folder = join(studio.files, 'page');
    mkdirSync(join(folder, 'node_modules/@halflight/three'), { recursive: true });
    execFileSync('npm', ['pack', '--silent', '--offline', '--pack-destination', folder], { cwd: join(web, 'three'), stdio: ['ignore', 'pipe', 'ignore'] });
    const { version } = JSON.parse(readFileSync(join(web, 'three/package.json'), 'utf8'));
    execFileSync('tar', ['xzf', `halflight-three-${version}.tgz`, '-C', 'node_modules/@halflight/three', '--strip-components=1'], { cwd: folder });
    copyFileSync(studio.pathOf('courtyard'), join(folder, 'courtyard-baked.glb'));
    const render = ['-o', join(studio.files, 'documents.png'), '--size', `${SIZE.width}x${SIZE.height}`, '--samples', '1', '--penumbrae', 'off', '--shadow-distance', '60', '--shadow-fade-range', '1', '--json'];
    const { exposure, mode } = JSON.parse(halflight('render', studio.pathOf('courtyard'), ...render));
    assert.equal(mode, 'shadowmask');
    const text = readFileSync(join(repository, 'docs/web.md'), 'utf8');
    const script = blockOf(text, 'js');
    assert.match(script, /^const EV = 2;$/m);
    assert.match(script, /antialias: true/);
    const own = script.replace('const EV = 2;', `const EV = ${exposure};`).replace('antialias: true', 'antialias: false'); // one sample a pixel, as all pictures here
    writeFileSync(join(folder, 'main.js'), own);
    writeFileSync(join(folder, 'index.html'), blockOf(text, 'html'));
    const server = await serve(studio.files, 'three', { '/page/node_modules/three/': join(web, 'node_modules/three'), '/page/': folder });
    const page = await studio.newPage({ viewport: SIZE });
    const trouble = [];
    page.on('pageerror', (error) => trouble.push(String(error)));
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && !/favicon|GPU stall|404/.test(message.text()) && trouble.push(message.text()));
    // Three frames: the page would draw on and on, which leaves a software renderer no time for a picture of it.
    await page.addInitScript(() => {
        const request = window.requestAnimationFrame.bind(window);
        window.framesLeft = 3;
        window.requestAnimationFrame = (draw) => (window.framesLeft-- > 0 ? request(draw) : 0);
    });
    await page.goto(`${server.url}/page/index.html`);
    await page.waitForFunction('window.framesLeft < 0', null, { polling: 500 });
    const ours = (await page.screenshot()).toString('base64');
    if (look) writeFileSync(join(look, 'documents.png'), Buffer.from(ours, 'base64'));
    const result = await page.evaluate(differenceOf, { ours, reference: '/files/documents.png' });
    await page.close();
    server.close();
    console.log(`the documents' page: ${result.mean.toFixed(3)} of 255`);
    assert.deepEqual(trouble, []);
    assert.ok(result.light > 40 && result.mean <= 1.5, `${result.mean} of 255, mean level ${result.light}`);
});
