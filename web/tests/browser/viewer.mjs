// The viewer's folder, served as it stands and without any other network.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { repository, serveFolder, web } from '../harness.mjs';
import { studio } from './studio.mjs';

const folder = mkdtempSync(join(tmpdir(), 'halflight-viewer-'));
const conformance = join(repository, 'assets/conformance');
let server = null;
after(() => {
    server?.close();
    rmSync(folder, { recursive: true });
});

/** @param {string} address of the file and the view; the showcase where it names no file */
async function open(address = '?file=sphere_on_floor.glb', viewport = { width: 660, height: 320 }) {
    if (!server) {
        execFileSync(process.execPath, [join(web, 'scripts/build_viewer.mjs'), folder, join(conformance, 'five_lights.glb')]);
        for (const name of ['sphere_on_floor.glb', 'avenue.glb']) copyFileSync(join(conformance, name), join(folder, name));
        writeFileSync(join(folder, 'plain.glb'), 'not glTF');
        server = await serveFolder(folder);
    }
    const page = await studio.newPage({ viewport });
    const errors = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('request', (request) => {
        const own = request.url().startsWith(server.url) || /^(data|blob):/.test(request.url());
        if (!own) errors.push(`asks for ${request.url()}`);
    });
    await page.goto(`${server.url}/index.html${address}`);
    const frames = () => page.evaluate(() => Number(document.body.dataset.frames ?? 0));
    /** Waits for a frame after `act`; a frame that an earlier change requested is drawn before it. */
    const drawn = async (act = async () => {}) => {
        await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
        const before = await frames();
        await act();
        await page.waitForFunction((n) => Number(document.body.dataset.frames ?? 0) > n, before);
    };
    /** Frames drawn and frames requested in a second in which nothing changes, after those of earlier changes. */
    const still = () =>
        page.evaluate(async () => {
            const request = requestAnimationFrame;
            await new Promise((resolve) => request(() => request(resolve)));
            const before = Number(document.body.dataset.frames);
            let requests = 0;
            window.requestAnimationFrame = (callback) => (++requests, request(callback));
            await new Promise((resolve) => setTimeout(resolve, 1000));
            window.requestAnimationFrame = request;
            return { drawn: Number(document.body.dataset.frames) - before, requests };
        });
    if ((await frames()) === 0) await page.waitForFunction(() => Number(document.body.dataset.frames ?? 0) > 0);
    const link = async () => {
        await page.click('#link');
        return new URLSearchParams(await page.evaluate(() => location.hash.slice(1)));
    };
    const text = (selector) => page.evaluate((s) => document.querySelector(s).textContent, selector);
    return { page, errors, drawn, still, link, text, picture: () => page.locator('#picture').screenshot() };
}

test('the viewer opens the showcase as its link says, and shows what the file holds', async () => {
    const { page, errors, text } = await open('#mode=distance-shadowmask&distance=20');
    assert.equal(await page.inputValue('#modes input:checked'), 'distance-shadowmask');
    assert.equal(await text('#distanceValue'), '20 m');
    const disabled = await page.$$eval('#lights input[type=checkbox]', (inputs) => inputs.filter((input) => input.disabled).length);
    assert.equal(disabled, 1, 'the fully baked light cannot be switched');
    const statistics = await text('#statistics');
    assert.match(statistics, /draw calls[1-9]/);
    for (const part of ['lightmaps', 'shadowmasks', 'probes']) assert.match(statistics, new RegExp(`${part}[^M]*\\d\\.\\d\\d MB`), part);
    assert.deepEqual(errors, []);
    await page.close();
});

test('the viewer: orbit, fly, no frame without a change, and a link opened in a narrow window', async () => {
    const { page, errors, drawn, still, link } = await open();
    const before = await link();
    assert.deepEqual(await still(), { drawn: 0, requests: 0 }, 'after the file');
    await drawn(async () => {
        await page.mouse.move(400, 160);
        await page.mouse.down();
        await page.mouse.move(440, 180, { steps: 4 });
        await page.mouse.up();
    });
    const turned = await link();
    assert.notEqual(turned.get('eye'), before.get('eye'));
    assert.equal(turned.get('target'), before.get('target'), 'orbiting keeps the target');
    await page.keyboard.down('KeyW');
    for (let i = 0; i < 3; ++i) await drawn(); // the first frame measures no time yet
    await page.keyboard.up('KeyW');
    const flown = await link();
    assert.deepEqual(await still(), { drawn: 0, requests: 0 }, 'after the flight');
    await drawn(() => page.setViewportSize({ width: 670, height: 320 }));
    await drawn(() => page.locator('#exposure').fill('1'));
    assert.deepEqual(await still(), { drawn: 0, requests: 0 }, 'after a setting');
    assert.notEqual(flown.get('target'), turned.get('target'), 'flying moves what is orbited too');
    await page.close();
    const again = await open(`?file=sphere_on_floor.glb#${flown}`, { width: 320, height: 480 });
    assert.equal(await again.page.isVisible('#modes'), false, 'the panel leaves the picture free');
    await again.page.click('#panel summary');
    const arrived = await again.link();
    for (const key of ['eye', 'target', 'fov', 'mode', 'view', 'distance', 'fade', 'exposure']) assert.equal(arrived.get(key), flown.get(key), key);
    await again.drawn(() => again.page.evaluate(() => (location.hash = 'mode=realtime&view=lightmap&distance=7')));
    assert.equal(await again.page.inputValue('#modes input:checked'), 'realtime', 'a link followed');
    const followed = await again.link();
    assert.deepEqual([followed.get('view'), followed.get('distance')], ['lightmap', '7']);
    assert.deepEqual([...errors, ...again.errors], []);
    await again.page.close();
});

test('the viewer: modes, views, lights and shadow distance change the picture', async () => {
    const { page, errors, drawn, picture } = await open('?file=avenue.glb#mode=shadowmask');
    const pictures = new Map([['shadowmask', await picture()]]);
    const change = async (name, act) => {
        await drawn(act);
        const now = await picture();
        for (const [other, bytes] of pictures) assert.ok(!bytes.equals(now), `${name} shows another picture than ${other}`);
        pictures.set(name, now);
    };
    await change('baked-indirect', () => page.check('#modes input[value=baked-indirect]'));
    await change('realtime', () => page.check('#modes input[value=realtime]'));
    await change('a shorter shadow distance', () => page.locator('#distance').fill('4'));
    await change('the shadowmask view', () => page.selectOption('#view', 'shadowmask'));
    await change('the lightmap view', () => page.selectOption('#view', 'lightmap'));
    await drawn(() => page.selectOption('#view', 'lit'));
    await change('one light less', () => page.uncheck('#lights input[type=checkbox]:not(:disabled)'));
    assert.deepEqual(errors, []);
    await page.close();
});

test('the viewer takes files by choice and by drop, and says what is wrong with others', async () => {
    const { page, errors, drawn, text } = await open();
    await page.setInputFiles('#open', join(folder, 'plain.glb'));
    await page.waitForFunction(() => document.querySelector('#message').textContent.startsWith('plain.glb: '));
    assert.equal(await text('#file'), 'sphere_on_floor.glb', 'what was open stays');
    await drawn(() => page.setInputFiles('#open', join(conformance, 'bumpy_wall.glb')));
    assert.equal(await text('#file'), 'bumpy_wall.glb');
    const bytes = readFileSync(join(conformance, 'sphere_on_floor_subtractive.glb')).toString('base64');
    await drawn(() =>
        page.evaluate(async (base64) => {
            const blob = await (await fetch(`data:application/octet-stream;base64,${base64}`)).blob();
            const dataTransfer = new DataTransfer();
            dataTransfer.items.add(new File([blob], 'dropped.glb'));
            document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
            while (document.querySelector('#file').textContent !== 'dropped.glb') await new Promise((resolve) => setTimeout(resolve, 20));
        }, bytes)
    );
    assert.deepEqual(await page.$$eval('#modes input', (inputs) => inputs.map((input) => input.value)), ['realtime', 'subtractive']);
    await page.evaluate(() => {
        const read = File.prototype.arrayBuffer;
        File.prototype.arrayBuffer = async function () {
            if (this.name === 'avenue.glb') await new Promise((resolve) => (window.readAvenue = resolve));
            return read.call(this);
        };
    });
    await page.setInputFiles('#open', join(conformance, 'avenue.glb'));
    await drawn(() => page.setInputFiles('#open', join(conformance, 'bumpy_wall.glb')));
    await drawn(() => page.evaluate(() => window.readAvenue()));
    assert.equal(await text('#file'), 'bumpy_wall.glb', 'the file chosen last, though the one before it is read later');
    assert.deepEqual(errors, []);
    await page.close();
});
