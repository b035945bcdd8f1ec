// The viewer page bakes: as build_viewer.mjs makes it, on a static host that sets no headers.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { launch, newPage, repository, serveFolder, web } from '../harness.mjs';
import { differenceFromProgram, pictureOf } from '../viewer_picture.mjs';
import { halflight, hashOf, scene, workspace } from './workspace.mjs';

const axe = createRequire(import.meta.url).resolve('axe-core/axe.min.js');
const folder = mkdtempSync(join(tmpdir(), 'halflight-page-'));
const at = (name) => join(folder, name);
let browser;
let server;
before(async () => {
    const showcase = join(repository, 'assets/conformance/sphere_on_floor.glb');
    execFileSync(process.execPath, [join(web, 'scripts/build_viewer.mjs'), at('viewer'), showcase]);
    server = await serveFolder(at('viewer'));
    browser = await launch();
});
after(async () => {
    await browser?.close();
    server?.close();
    rmSync(folder, { recursive: true });
});

/** The page in a browser that was never there, once it is isolated and shows the showcase. */
async function open(address = 'index.html') {
    const context = await browser.newContext({ viewport: { width: 660, height: 420 }, acceptDownloads: true });
    const page = await newPage(context);
    const faults = [];
    const requests = [];
    page.on('pageerror', (error) => faults.push(String(error)));
    context.on('request', (request) => {
        requests.push(request.url());
        const isOwn = request.url().startsWith(server.url) || /^(data|blob):/.test(request.url());
        if (!isOwn || request.method() !== 'GET') faults.push(`${request.method()} ${request.url()}`);
    });
    const visits = [];
    page.on('framenavigated', () => visits.push(page.url()));
    await page.goto(`${server.url}/${address}`);
    await page.waitForFunction(() => crossOriginIsolated && document.body.dataset.picture === 'whole');
    const text = (selector) => page.evaluate((s) => document.querySelector(s).textContent, selector);
    const says = (selector, part) => page.waitForFunction(([s, p]) => document.querySelector(s).textContent.includes(p), [selector, part]);
    const whole = () => page.waitForFunction(() => document.body.dataset.picture === 'whole');
    /** Opens files of this computer. */
    const choose = async (paths, name, input = '#open') => {
        await page.setInputFiles(input, paths);
        await says('#file', name);
        await page.waitForSelector('#bakery:not([hidden])');
    };
    const bake = async (options) => {
        for (const [id, value] of Object.entries(options)) {
            const isList = id !== 'texels';
            if (isList) await page.selectOption(`#${id}`, value);
            else await page.fill(`#${id}`, value);
        }
        await page.click('#bake');
    };
    const baked = async () => {
        await page.waitForSelector('#download:not([hidden])');
        await whole();
        const [download] = await Promise.all([page.waitForEvent('download'), page.click('#download')]);
        return { name: download.suggestedFilename(), path: await download.path() };
    };
    const close = async () => {
        await context.close();
        assert.deepEqual(faults, []);
    };
    return { page, requests, visits, text, says, whole, choose, bake, baked, close };
}

/** The hash of what the command makes of a file. */
function hashOfCommand(file, options) {
    const { status, stderr } = halflight(['bake', file, '-o', join(workspace(), 'command.glb'), '-q', ...options]);
    assert.equal(status, 0, stderr);
    return hashOf(join(workspace(), 'command.glb'));
}

const modes = (page) => page.$$eval('#modes input', (inputs) => inputs.map((input) => input.value));

test('the page bakes a dropped file: the command\'s bytes, the program\'s picture, beside what it was', async () => {
    const { page, requests, visits, text, choose, bake, baked, close } = await open();
    assert.equal(visits.length, 2, 'the page was loaded again once');
    await choose(scene('sphere_on_floor'), 'sphere_on_floor.glb');
    assert.deepEqual(await modes(page), ['realtime']);
    assert.match(await text('#bakeSentence'), /stay on this computer/);
    assert.ok(!requests.some((url) => url.includes('/bake/')), 'no baker before the button is pressed');
    const stages = page.evaluate(() => new Promise((resolve) => {
        const seen = [];
        const text = (id) => document.querySelector(id).textContent;
        const observer = new MutationObserver(() => seen.push(`${text('#bakeStage')}. ${text('#bakeNext')}`));
        observer.observe(document.querySelector('#bakeStage'), { childList: true });
        new MutationObserver(() => document.querySelector('#download').hidden || resolve(seen)).observe(document.querySelector('#download'), { attributes: true });
    }));
    await bake({ quality: 'preview' });
    const file = await baked();
    const seen = await stages;
    const promised = seen.find((line) => line.includes('Then: ')).match(/Then: (.*)\./)[1].split(', ');
    assert.ok(promised.includes('lightmap') && promised.includes('shadowmask'), promised.join());
    const places = promised.map((stage) => seen.findIndex((line) => line.startsWith(`${stage}: `)));
    assert.ok(places.every((place, i) => place > (places[i - 1] ?? -1)), `stages come as promised: ${seen.join('\n')}`);
    assert.equal(file.name, 'sphere_on_floor-baked.glb');
    assert.equal(hashOf(file.path), hashOfCommand(scene('sphere_on_floor'), ['--quality', 'preview']));
    assert.deepEqual(await modes(page), ['realtime', 'baked-indirect', 'shadowmask', 'distance-shadowmask']);
    // The baked file alone, by the program and by the page.
    cpSync(file.path, at('downloaded.glb'));
    const slide = (value) => page.evaluate((v) => {
        const slider = document.querySelector('#split');
        slider.value = v;
        slider.dispatchEvent(new Event('input'));
    }, value);
    await page.evaluate(() => (document.querySelector('#panel').open = false));
    await slide('0');
    for (const mode of ['shadowmask', 'baked-indirect', 'realtime']) {
        await page.evaluate((m) => document.querySelector(`#modes input[value=${m}]`).click(), mode);
        const { mean, light } = await differenceFromProgram(page, at('downloaded.glb'));
        console.log(`${mode}: ${mean.toFixed(2)} of 255 from halflight render`);
        assert.ok(light > 20 && mean < 1.5, `${mode}: mean difference ${mean} of 255, mean level ${light}`);
    }
    // Before on the left of the divider, baked on its right.
    await page.evaluate(() => document.querySelector('#modes input[value=shadowmask]').click());
    const pictures = {};
    for (const value of ['0', '50', '100']) {
        await slide(value);
        await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
        pictures[value] = (await pictureOf(page)).toString('base64');
    }
    const differ = await page.evaluate(async (all) => {
        const pixels = {};
        for (const [name, base64] of Object.entries(all)) {
            const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
            const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
            context.drawImage(bitmap, 0, 0);
            pixels[name] = (left) => context.getImageData(left, 0, 320, 420).data;
        }
        const count = (a, b, left) => {
            const [x, y] = [pixels[a](left), pixels[b](left)];
            return x.reduce((sum, value, i) => sum + Number(Math.abs(value - y[i]) > 1), 0);
        };
        return { was: count('50', '100', 0), is: count('50', '0', 340), all: count('0', '100', 0) };
    }, pictures);
    assert.ok(differ.was < 50 && differ.is < 50 && differ.all > 10000, JSON.stringify(differ));
    await close();
});

test('a folder bakes as the command bakes it; axe finds nothing on the page', async () => {
    const { json, buffer } = readGlb(scene('closed_room'));
    json.buffers[0].uri = '../parts/all%20of%20it.bin';
    for (const name of ['room/scene', 'room/parts']) mkdirSync(at(name), { recursive: true });
    writeFileSync(at('room/scene/room.gltf'), JSON.stringify(json));
    writeFileSync(at('room/parts/all of it.bin'), buffer);
    const { page, choose, bake, baked, close } = await open();
    await choose(at('room'), 'room.gltf', '#folder');
    await bake({ quality: 'preview', bakeMode: 'subtractive', texels: '4' });
    const file = await baked();
    const options = ['--quality', 'preview', '--mode', 'subtractive', '--texels-per-meter', '4'];
    assert.equal(hashOf(file.path), hashOfCommand(at('room/scene/room.gltf'), options));
    assert.deepEqual(await modes(page), ['realtime', 'subtractive']);
    await page.addScriptTag({ path: axe });
    const { violations } = await page.evaluate(() => window.axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] }));
    assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html)}`), []);
    await close();
});

test('the program\'s sentence for a broken file; then another file bakes', async () => {
    const { json, buffer } = readGlb(scene('sphere_on_floor'));
    const sentenceOf = (file) => halflight(['bake', file, '-o', at('none.glb'), '-q']).stderr.replace(/^halflight: /, '').replace(`${file}: `, '').trim();
    // One that the page shows, and one that it cannot show.
    json.nodes.push({ name: 'odd', scale: [1, 1, 'x'] });
    writeGlb(at('odd.glb'), { json, buffer });
    const cut = readFileSync(scene('sphere_on_floor'));
    writeFileSync(at('cut.glb'), cut.subarray(0, cut.length - 1000));
    const { text, says, choose, bake, baked, close } = await open();
    for (const name of ['odd.glb', 'cut.glb']) {
        const sentence = sentenceOf(at(name));
        assert.ok(sentence.length > 10, sentence);
        await choose(at(name), name);
        await bake({ quality: 'preview' });
        await says('#message', 'cannot be baked');
        assert.equal(await text('#message'), `${name} cannot be baked: ${sentence}.`);
    }
    await choose(scene('sphere_on_floor'), 'sphere_on_floor.glb');
    await bake({ quality: 'preview', texels: '-1' });
    await says('#message', '--texels-per-meter: ');
    await bake({ quality: 'preview', texels: '' });
    await baked();
    assert.equal(await text('#message'), '');
    await close();
});

test('a baker that cannot be fetched is a sentence, and the next press fetches it; a name that looks like an option', async () => {
    const { page, text, says, choose, bake, baked, close } = await open();
    cpSync(scene('closed_room'), at('-Zimmer ä.glb'));
    await choose(at('-Zimmer ä.glb'), '-Zimmer ä.glb');
    await page.context().setOffline(true);
    await bake({ quality: 'preview' });
    await says('#message', 'the baker cannot be fetched');
    assert.equal(await text('#message'), '-Zimmer ä.glb cannot be baked: the baker cannot be fetched: the network is not reachable.');
    await page.context().setOffline(false);
    await bake({ quality: 'preview' });
    const file = await baked();
    assert.equal(file.name, '-Zimmer ä-baked.glb');
    assert.equal(hashOf(file.path), hashOfCommand(scene('closed_room'), ['--quality', 'preview']));
    // Its first file is there now; the others of each bake are fetched anew.
    await page.context().setOffline(true);
    await bake({ quality: 'preview' });
    await says('#message', 'cannot be baked');
    assert.equal(await text('#message'), '-Zimmer ä.glb cannot be baked: the baker cannot be fetched: the network is not reachable.');
    await page.context().setOffline(false);
    await bake({ quality: 'preview' });
    assert.equal(hashOf((await baked()).path), hashOf(file.path));
    await close();
});

test('a bake is cancelled, by the button and by another file; the next one has the same bytes', async () => {
    const { page, text, says, choose, bake, baked, close } = await open();
    await choose(scene('closed_room'), 'closed_room.glb');
    await bake({ quality: 'ultra' });
    await says('#bakeStage', '%');
    await page.click('#cancel');
    await says('#bakeState', 'The bake was cancelled.');
    assert.equal(await page.isVisible('#bake'), true);
    await bake({ quality: 'ultra' });
    await says('#bakeStage', '%');
    await choose(scene('sphere_on_floor'), 'sphere_on_floor.glb');
    assert.equal(await page.isVisible('#baking'), false);
    const hashes = [];
    for (let i = 0; i < 2; ++i) {
        await bake({ quality: 'preview' });
        await page.waitForSelector('#baking:not([hidden])');
        hashes.push(hashOf((await baked()).path));
    }
    assert.deepEqual(hashes, Array(2).fill(hashOfCommand(scene('sphere_on_floor'), ['--quality', 'preview'])));
    assert.equal(await text('#file'), 'sphere_on_floor-baked.glb');
    await close();
});

test('a hard reload is isolated again, and a frame of a page that is not says why it cannot bake', async () => {
    const { page, close } = await open();
    await (await page.context().newCDPSession(page)).send('Page.reload', { ignoreCache: true });
    await page.waitForFunction(() => crossOriginIsolated && document.body.dataset.picture === 'whole');
    await close();
    writeFileSync(at('viewer/around.html'), '<!doctype html><iframe src="index.html" title="viewer" width="700" height="400"></iframe>');
    const outer = await newPage(await browser.newContext());
    await outer.goto(`${server.url}/around.html`);
    const frame = await (await outer.waitForSelector('iframe')).contentFrame();
    await frame.waitForFunction(() => document.body.dataset.picture === 'whole');
    await frame.setInputFiles('#open', scene('sphere_on_floor'));
    await frame.waitForSelector('#bakery:not([hidden])');
    assert.equal(await frame.isDisabled('#bake'), true);
    assert.match(await frame.textContent('#bakeSentence'), /part of another page that is not isolated/);
    await outer.context().close();
});
