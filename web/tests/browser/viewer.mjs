// The viewer: what it opens, what its controls change, and its links.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb } from '../glb.mjs';
import { repository } from '../harness.mjs';
import { bakeGroups } from './groups_scene.mjs';
import { studio } from './studio.mjs';
import { close, conformance, drop, folder, open } from './viewer_page.mjs';
import { differenceFromProgram } from '../viewer_picture.mjs';

const VIEW = ['eye', 'target', 'fov', 'mode', 'view', 'distance', 'fade', 'exposure'];

test('the viewer: no frame without a change, and a link gives its view in a narrow window', async () => {
    const viewer = await open();
    const { page, drawn, link } = viewer;
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
    assert.deepEqual(await still(), { drawn: 0, requests: 0 }, 'after the file');
    await drawn(() => page.setViewportSize({ width: 670, height: 320 }));
    await drawn(() => page.locator('#exposure').fill('1'));
    await drawn(async () => {
        await page.mouse.move(500, 160);
        await page.mouse.down();
        await page.mouse.move(540, 180, { steps: 4 });
        await page.mouse.up();
    });
    await page.keyboard.down('KeyW');
    for (let i = 0; i < 3; ++i) await drawn(); // the first frame measures no time yet
    await page.keyboard.up('KeyW');
    assert.deepEqual(await still(), { drawn: 0, requests: 0 }, 'after all of this');
    const sent = await link();
    assert.equal(sent.get('exposure'), '1');
    const again = await open(`?file=sphere_on_floor.glb#${sent}`, { viewport: { width: 320, height: 480 } });
    assert.equal(await again.page.isVisible('#modes'), false, 'the panel leaves the picture free');
    await again.page.click('#panel summary');
    const arrived = await again.link();
    for (const key of VIEW) assert.equal(arrived.get(key), sent.get(key), key);
    await again.drawn(() => again.page.evaluate(() => (location.hash = 'mode=realtime&view=lightmap&distance=7')));
    assert.equal(await again.page.inputValue('#modes input:checked'), 'realtime', 'a link followed');
    const followed = await again.link();
    assert.deepEqual([followed.get('view'), followed.get('distance')], ['lightmap', '7']);
    await close(viewer);
    await close(again);
});

test('the viewer: modes, views, lights and shadow distance change the picture, and views have legends', async () => {
    const viewer = await open('?file=avenue.glb#mode=shadowmask');
    const { page, drawn, picture, text } = viewer;
    const pictures = new Map([['shadowmask', await picture()]]);
    const change = async (name, act) => {
        await drawn(act);
        const now = await picture();
        for (const [other, bytes] of pictures)
            assert.ok(!bytes.equals(now), `${name} shows another picture than ${other}`);
        pictures.set(name, now);
    };
    await change('baked-indirect', () => page.check('#modes input[value=baked-indirect]'));
    await change('realtime', () => page.check('#modes input[value=realtime]'));
    await change('a shorter shadow distance', () => page.locator('#distance').fill('4'));
    await change('the lightmap view', () => page.selectOption('#view', 'lightmap'));
    assert.match(await text('#legend'), /white wall/);
    await change('the overlap view', () => page.selectOption('#view', 'overlap'));
    assert.equal(await page.locator('#legend li').count(), 6, 'colours');
    await drawn(() => page.check('#modes input[value=shadowmask]'));
    await change('the shadowmask view', () => page.selectOption('#view', 'shadowmask'));
    const sun = readGlb(join(conformance, 'avenue.glb')).json.nodes.find(
        (node) => node.extensions?.KHR_lights_punctual
    )?.name;
    assert.ok(
        (await page.locator('#legend li').allTextContents()).includes(`red where lit: ${sun}`),
        'channels by light'
    );
    await drawn(() => page.selectOption('#view', 'lit'));
    assert.equal(await text('#legend'), '');
    await change('one light less', () => page.uncheck('#lights input[type=checkbox]:not(:disabled)'));
    assert.match(await text('#notes'), /its bounced light stays/);
    await close(viewer);
});

test('the viewer: a colour and a brightness for each light group S33, and links that keep them', async () => {
    copyFileSync(studio.pathOf(bakeGroups()), join(folder, 'groups.glb'));
    const viewer = await open('?file=groups.glb&exposure=2');
    const { page, link, text } = viewer;
    /** Until no frame follows: a large proxy volume takes several. */
    const rest = async (own = page) => {
        const frames = () => own.evaluate(() => document.body.dataset.frames);
        for (let before = ''; before !== (await frames()); ) {
            before = await frames();
            await own.waitForTimeout(1500);
        }
    };
    const drawn = async (act) => {
        await viewer.drawn(act);
        await rest();
    };
    /** Beside the panel. */
    const picture = async (own = page) => {
        await rest(own);
        return own.screenshot({ clip: { x: 330, y: 0, width: 330, height: 320 } });
    };
    assert.equal(await page.locator('#groups input[type=range]').count(), 5);
    assert.match(await text('#statistics'), /light groups, 5[^M]*\d\.\d\d MB/);
    assert.match(await text('#lights'), /lampof light group lamp/);
    assert.equal((await link()).get('weights'), null, 'the weights are those of the file');
    const saved = await picture();
    const range = page.locator('#groups input[aria-label="Brightness of lamp"]');
    const color = page.locator('#groups input[aria-label="Colour of lamp"]');
    assert.equal(await color.inputValue(), '#ff593f', 'red, 0.1 of green and 0.05 of blue');
    await drawn(() => range.fill('0'));
    const off = await picture();
    assert.ok(!off.equals(saved), 'the lamp is off');
    assert.equal(await text('#notes'), '', 'reflection probes follow too');
    await drawn(() => color.fill('#0000ff'));
    assert.ok((await picture()).equals(off), 'a colour of a lamp that is off shows nothing yet');
    await drawn(() => range.fill('2'));
    const blue = await picture();
    assert.ok(!blue.equals(off) && !blue.equals(saved), 'a blue lamp');
    const sent = await link();
    const weights = sent.get('weights').split(',').map(Number);
    assert.equal(weights.length, 15);
    assert.ok(weights.join().includes('0,0,2'), weights.join());
    const again = await open(`?file=groups.glb#${sent}`);
    assert.equal((await again.link()).get('weights'), sent.get('weights'), 'the link keeps the weights');
    assert.equal(await again.page.inputValue('#groups input[aria-label="Colour of lamp"]'), '#0000ff');
    await again.drawn(() => again.page.evaluate(() => (location.hash = 'exposure=2&weights=1,2')));
    assert.match(await again.text('#notes'), /weights=1,2, which is left out: it takes 15 numbers from 0 on/);
    await close(again);
    await drawn(() => page.click('#saved'));
    assert.ok((await picture()).equals(saved), 'as the file has them');
    await viewer.choose(join(conformance, 'sphere_on_floor.glb'));
    assert.equal(await page.isVisible('#groupsSection'), false, 'a file without groups');
    await close(viewer);
});

test('the viewer: values of debug views are in the picture as they are', async () => {
    const viewer = await open('?file=avenue.glb&view=fade&distance=8&fade=0.1&exposure=5', {
        script: () => {
            const get = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, options) {
                return get.call(this, kind, { ...options, preserveDrawingBuffer: true });
            };
        },
    });
    const shades = await viewer.page.evaluate(async () => {
        const picture = document.querySelector('#picture');
        const context = new OffscreenCanvas(picture.width, picture.height).getContext('2d');
        context.drawImage(picture, 0, 0);
        const { data } = context.getImageData(0, 0, picture.width, picture.height);
        const all = {};
        for (let i = 0; i < data.length; i += 4) all[data[i]] = (all[data[i]] ?? 0) + 1;
        return all;
    });
    assert.ok(
        shades[0] > 1000 && shades[255] > 1000,
        `black within the shadow distance, white beyond it: ${JSON.stringify(shades)}`
    );
    await close(viewer);
});

test('the viewer takes files by choice and by drop; none of them takes the view of an old link', async () => {
    const address = '?file=sphere_on_floor.glb#mode=realtime&exposure=9&eye=900,900,900&target=901,900,900';
    const viewer = await open(address);
    const { page, drawn, choose, link, text } = viewer;
    assert.equal((await link()).get('exposure'), '9');
    await choose(join(conformance, 'bumpy_wall.glb'));
    assert.equal(await text('#file'), 'bumpy_wall.glb');
    const later = await link();
    assert.equal(later.get('mode'), 'shadowmask');
    assert.ok(Number(later.get('exposure')) < 6, `exposure ${later.get('exposure')}`);
    assert.ok(
        later
            .get('eye')
            .split(',')
            .every((x) => Math.abs(x) < 100),
        later.get('eye')
    );
    assert.equal(later.get('local'), 'bumpy_wall.glb', 'the link says which file it is about');
    assert.ok(!(await page.evaluate(() => location.search)).includes('file='));
    await drawn(() =>
        drop(page, readFileSync, [{ name: 'dropped.glb', path: join(conformance, 'sphere_on_floor_subtractive.glb') }])
    );
    assert.equal(await text('#file'), 'dropped.glb');
    assert.deepEqual(await page.$$eval('#modes input', (inputs) => inputs.map((input) => input.value)), [
        'realtime',
        'subtractive',
    ]);
    await page.evaluate(() => {
        const read = File.prototype.arrayBuffer;
        File.prototype.arrayBuffer = async function () {
            if (this.name === 'avenue.glb') await new Promise((resolve) => (window.readAvenue = resolve));
            return read.call(this);
        };
    });
    await page.setInputFiles('#open', join(conformance, 'avenue.glb'));
    await choose(join(conformance, 'bumpy_wall.glb'));
    await page.evaluate(() => window.readAvenue());
    await page.waitForTimeout(500);
    assert.equal(await text('#file'), 'bumpy_wall.glb', 'the file chosen last, though the one before it is read later');
    await drawn(() => page.evaluate(() => (location.hash = 'mode=realtime')));
    await page.waitForFunction(() => document.querySelector('#file').textContent === 'courtyard-baked.glb');
    assert.equal(await page.inputValue('#modes input:checked'), 'realtime', 'a link to another file opens that file');
    await close(viewer);
});

test('the viewer shows a folder with a file that is not baked, in realtime mode', async () => {
    const viewer = await open('?file=sphere_on_floor.glb');
    const { page, choose, text, drawn } = viewer;
    assert.equal(await page.isVisible('#bakery'), false, 'there is nothing to bake');
    const { json, buffer } = readGlb(join(repository, 'assets/tests/sphere_on_floor.glb'));
    json.buffers[0].uri = 'parts/all%20of%20it.bin';
    mkdirSync(join(folder, 'plain/parts'), { recursive: true });
    writeFileSync(join(folder, 'plain/scene.gltf'), JSON.stringify(json));
    writeFileSync(join(folder, 'plain/parts/all of it.bin'), buffer);
    await drawn(() => page.setInputFiles('#folder', join(folder, 'plain')));
    await viewer.whole();
    assert.equal(await text('#file'), 'scene.gltf');
    assert.deepEqual(await page.$$eval('#modes input', (inputs) => inputs.map((input) => input.value)), ['realtime']);
    assert.match(await text('#bakeSentence'), /built without the baker/);
    const { mean, light } = await differenceFromProgram(page, join(folder, 'plain/scene.gltf'));
    console.log(`a file that is not baked: ${mean.toFixed(2)} of 255 from halflight render`);
    assert.ok(light > 20 && mean < 1.5, `mean difference ${mean} of 255, mean level ${light}`);
    await choose(join(conformance, 'bumpy_wall.glb'));
    assert.equal(await page.isVisible('#bakery'), false);
    // The folder by drop: Chromium gives entries to people's drops alone, so the test stands in for it.
    await page.evaluate(() => {
        const entries = new Map();
        const folderOf = (path, children) => ({
            isDirectory: true,
            fullPath: path,
            createReader: () => ({ readEntries: (take) => take(children.splice(0, 1).map((child) => child())) }),
        });
        const fileOf = (path) => ({ isFile: true, fullPath: path, file: (take) => take(entries.get(path)) });
        window.take = (name, path, text) => entries.set(path, new File([text], name));
        DataTransferItem.prototype.webkitGetAsEntry = () =>
            folderOf('/plain', [
                () => folderOf('/plain/parts', [() => fileOf('/plain/parts/all of it.bin')]),
                () => fileOf('/plain/scene.gltf'),
            ]);
    });
    await page.evaluate(
        ([text, bytes]) => {
            window.take('scene.gltf', '/plain/scene.gltf', text);
            window.take('all of it.bin', '/plain/parts/all of it.bin', Uint8Array.from(bytes));
        },
        [JSON.stringify(json), [...buffer]]
    );
    await drop(page, readFileSync, [{ name: 'plain', path: join(folder, 'plain/scene.gltf') }]);
    await viewer.says('#file', 'scene.gltf');
    assert.equal(await text('#message'), '');
    await close(viewer);
});

test('the viewer: a link to a file without an address asks for it, and gives it its view', async () => {
    const viewer = await open('#local=avenue.glb&mode=realtime&exposure=3.5', { drawn: false });
    await viewer.says('#file', 'The link shows avenue.glb');
    await viewer.choose(join(conformance, 'avenue.glb'));
    const view = await viewer.link();
    assert.deepEqual([view.get('mode'), view.get('exposure'), view.get('local')], ['realtime', '3.5', 'avenue.glb']);
    await close(viewer);
});

test('the viewer says when a link was copied, and gives code that embeds the view', async () => {
    const viewer = await open('?file=sphere_on_floor.glb', { permissions: ['clipboard-read', 'clipboard-write'] });
    const { page, url, says } = viewer;
    const clipboard = () => page.evaluate(() => navigator.clipboard.readText());
    await page.click('#link');
    await says('#copied', 'The link was copied.');
    assert.equal(await clipboard(), page.url());
    await page.click('#embed');
    await says('#copied', 'The code was copied.');
    const code = await clipboard();
    assert.match(code, /^<iframe src="[^"]+" title="sphere_on_floor.glb"/);
    await page.evaluate(() => (navigator.clipboard.writeText = () => Promise.reject(new Error('no'))));
    await page.click('#link');
    await says('#copied', 'Copy it yourself: http');
    await page.setContent(`<body style="margin: 0">${code}</body>`);
    const frame = await (await page.waitForSelector('iframe')).contentFrame();
    await frame.waitForFunction(() => document.body.dataset.picture === 'whole' && document.body.dataset.frames > 1);
    assert.ok(frame.url().startsWith(url));
    assert.equal(await frame.isVisible('aside'), false, 'no panel in it');
    assert.deepEqual(await frame.locator('#picture').boundingBox(), { x: 0, y: 0, width: 960, height: 540 });
    await close(viewer);
});

test('the viewer: one small script, and a first picture of half the resolution without realtime shadows', async () => {
    const viewer = await open('?file=sphere_on_floor.glb&mode=realtime', {
        script: () => {
            window.log = [];
            const storage = WebGL2RenderingContext.prototype.texStorage2D;
            WebGL2RenderingContext.prototype.texStorage2D = function (target, levels, format, width, height) {
                if ([this.DEPTH_COMPONENT16, this.DEPTH_COMPONENT24, this.DEPTH_COMPONENT32F].includes(format))
                    window.log.push(['depth', width, height]);
                return storage.call(this, target, levels, format, width, height);
            };
            addEventListener('DOMContentLoaded', () => {
                const { body } = document;
                new MutationObserver(() => {
                    const { width, height } = document.querySelector('canvas');
                    window.log.push([body.dataset.picture, width, height]);
                }).observe(body, { attributes: true, attributeFilter: ['data-frames'] });
            });
        },
    });
    const log = await viewer.page.evaluate(() => window.log);
    const first = log.findIndex(([what]) => what === 'first');
    const shadows = log.findIndex(([what, width]) => what === 'depth' && width >= 1024);
    assert.deepEqual(log[first], ['first', 330, 160], JSON.stringify(log));
    assert.deepEqual(log.at(-1), ['whole', 660, 320]);
    assert.ok(shadows > first, `shadow maps come after the first picture: ${JSON.stringify(log)}`);
    const size = statSync(join(folder, 'viewer.js')).size;
    assert.ok(size < 950_000, `viewer.js has ${size} bytes`);
    const scripts = await viewer.page.evaluate(
        () => performance.getEntriesByType('resource').filter(({ name }) => name.endsWith('.js')).length
    );
    assert.equal(scripts, 1);
    await close(viewer);
});
