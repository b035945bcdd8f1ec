// The viewer in use: mouse, touch and keys, names and sizes of controls, phones, exposure, and what goes wrong.
import assert from 'node:assert/strict';
import { copyFileSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { halflight, repository } from '../harness.mjs';
import { close, conformance, drop, folder, open } from './viewer_page.mjs';

const axe = createRequire(import.meta.url).resolve('axe-core/axe.min.js');
const PHONE = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };
const numbers = (text) => text.split(',').map(Number);

/** Camera of a link: where it stands, and a function from points of the world to pixels of the picture. */
function cameraOf(link, { width, height }) {
    const [eye, target] = [numbers(link.get('eye')), numbers(link.get('target'))];
    const minus = (a, b) => a.map((x, i) => x - b[i]);
    const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const unit = (a) => a.map((x) => x / Math.sqrt(dot(a, a)));
    const forward = unit(minus(target, eye));
    const right = unit(cross(forward, [0, 1, 0]));
    const up = cross(right, forward);
    const scale = (0.5 * height) / Math.tan((Number(link.get('fov')) * Math.PI) / 360);
    const pixelOf = (point) => {
        const seen = minus(point, eye);
        const depth = dot(seen, forward);
        return [0.5 * width + (scale * dot(seen, right)) / depth, 0.5 * height - (scale * dot(seen, up)) / depth];
    };
    /** Where the ray of a pixel meets the floor, y = 0. */
    const floorAt = (x, y) => {
        const ray = forward.map((f, i) => f + (right[i] * (x - 0.5 * width) - up[i] * (y - 0.5 * height)) / scale);
        return eye.map((e, i) => e - (eye[1] / ray[1]) * ray[i]);
    };
    return { eye, forward, pixelOf, floorAt };
}

const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));

test('the viewer turns about what is under the pointer, and the wheel comes nearer to it', async () => {
    const size = { width: 640, height: 320 };
    const viewer = await open('?file=sphere_on_floor.glb&panel=closed', { viewport: size });
    const { page, drawn } = viewer;
    // The link button is in the panel, which would hide a part of the picture.
    const view = async () => {
        await page.evaluate(() => document.querySelector('#link').click());
        return cameraOf(new URLSearchParams(await page.evaluate(() => location.hash.slice(1))), size);
    };
    const before = await view();
    const place = [480, 270]; // right of the middle, and below it: floor
    const point = before.floorAt(...place);
    const isAt = (camera, x, y, what) =>
        assert.ok(
            distance(camera.pixelOf(point), [x, y]) < 2,
            `${what}: ${camera.pixelOf(point)} instead of ${x},${y}`
        );
    await drawn(async () => {
        await page.mouse.move(...place);
        await page.mouse.down();
        await page.mouse.move(place[0] + 60, place[1] - 20, { steps: 5 });
        await page.mouse.up();
    });
    const turned = await view();
    assert.ok(distance(turned.eye, before.eye) > 0.3, 'the camera moved');
    assert.ok(
        Math.abs(distance(turned.eye, point) - distance(before.eye, point)) < 0.02,
        'as far from the point as before'
    );
    isAt(turned, ...place, 'turning keeps the point where it was');
    await page.mouse.move(...place);
    await drawn(() => page.mouse.wheel(0, -300));
    const nearer = await view();
    assert.ok(distance(nearer.eye, point) < 0.9 * distance(turned.eye, point), 'nearer');
    isAt(nearer, ...place, 'the wheel keeps the point where it was');
    await drawn(async () => {
        await page.mouse.down({ button: 'right' });
        await page.mouse.move(place[0] - 50, place[1] + 10, { steps: 5 });
        await page.mouse.up({ button: 'right' });
    });
    isAt(await view(), place[0] - 50, place[1] + 10, 'panning moves the point with the pointer');
    await close(viewer);
});

test('the viewer by keys alone: the panel, flying, looking, modes, views, exposure', async () => {
    const viewer = await open('?file=sphere_on_floor.glb');
    const { page, drawn, link, text } = viewer;
    const hold = async (key) => {
        await page.keyboard.down(key);
        for (let i = 0; i < 2; ++i) await drawn(); // the first frame measures no time yet
        await page.keyboard.up(key);
    };
    await page.keyboard.press('Tab');
    assert.equal(await page.evaluate(() => document.activeElement.id), 'picture', 'the first stop');
    const start = cameraOf(await link(), { width: 660, height: 320 });
    await hold('KeyW');
    const flown = cameraOf(await link(), { width: 660, height: 320 });
    assert.ok(distance(flown.eye, start.eye) > 0.01 && distance(flown.forward, start.forward) < 0.01, 'W flies');
    await hold('ArrowLeft');
    const looked = cameraOf(await link(), { width: 660, height: 320 });
    assert.ok(
        distance(looked.eye, flown.eye) < 0.01 && distance(looked.forward, flown.forward) > 0.01,
        'an arrow looks'
    );
    await drawn(() => page.keyboard.press('1'));
    assert.equal(await page.inputValue('#modes input:checked'), 'realtime');
    await drawn(() => page.keyboard.press('v'));
    assert.equal(await page.inputValue('#view'), 'shadowmask');
    await drawn(() => page.locator('#exposure').fill('7'));
    await page.selectOption('#view', 'lit');
    await page.focus('#picture');
    await drawn(() => page.keyboard.press('x'));
    assert.match(await text('#exposureValue'), /automatic/);
    await drawn(() => page.keyboard.press('f'));
    assert.equal(await page.locator('#camera option:checked').textContent(), 'whole scene');
    // Every control of the panel can be reached, and keeps its own keys.
    const stops = new Set();
    for (let i = 0; i < 40; ++i) {
        await page.keyboard.press('Tab');
        stops.add(
            await page.evaluate(
                () =>
                    document.activeElement.id ||
                    document.activeElement.ariaLabel ||
                    document.activeElement.name ||
                    document.activeElement.tagName
            )
        );
    }
    for (const stop of [
        'picture',
        'SUMMARY',
        'open',
        'mode',
        'distance',
        'fade',
        'exposure',
        'automatic',
        'camera',
        'view',
        'link',
        'embed',
    ])
        assert.ok(stops.has(stop), `${stop} of ${[...stops]}`);
    await page.focus('#distance');
    const eye = (await link()).get('eye');
    await page.focus('#distance');
    await drawn(() => page.keyboard.press('ArrowLeft'));
    assert.equal(await text('#distanceValue'), '59.5 m');
    assert.equal((await link()).get('eye'), eye);
    await close(viewer);
});

/** A file whose names are long. */
function writeLongNames(path) {
    const file = readGlb(join(conformance, 'five_lights.glb'));
    for (const node of file.json.nodes)
        node.name = `${node.name}_with_a_name_that_goes_on_${'and_on_'.repeat(9)}to_its_end`;
    writeGlb(path, file);
}

/** What a page shows that is too small, cut, or beyond its sides. Runs in the page. */
function faultsOfLayout() {
    const faults = [];
    const shown = [...document.querySelectorAll('aside *')].filter((e) => e.checkVisibility());
    for (const e of shown) {
        const { width, height, left, right } = e.getBoundingClientRect();
        const name = `${e.tagName} ${e.id || e.textContent.slice(0, 30)}`;
        if (e.matches('button, input, select, summary') && (height < 24 || width < 24))
            faults.push(`${name} is ${width} × ${height}`);
        if (
            e.scrollWidth > e.clientWidth + 1 &&
            !e.matches('input, select') &&
            getComputedStyle(e).display !== 'inline'
        )
            faults.push(`${name} is cut`);
        if (left < 0 || right > innerWidth) faults.push(`${name} is beyond the sides`);
    }
    return { faults, controls: shown.filter((e) => e.matches('button, input, select, summary')).length };
}

for (const [what, options] of [
    ['desktop', { viewport: { width: 700, height: 400 } }],
    ['phone', PHONE],
]) {
    test(`the viewer on a ${what}: axe finds nothing, and no control is small, no name cut`, async () => {
        writeLongNames(join(folder, 'names.glb'));
        const viewer = await open('?file=names.glb&odd=1', options);
        const { page } = viewer;
        if (what === 'phone') await page.tap('#panel summary');
        await page.selectOption('#view', 'overlap');
        await page.setInputFiles('#open', join(folder, 'plain.glb'));
        await viewer.says('#message', 'plain.glb');
        const { faults, controls } = await page.evaluate(faultsOfLayout);
        assert.deepEqual(faults, []);
        assert.ok(controls > 20, `${controls} controls`);
        await page.addScriptTag({ path: axe });
        const { violations, incomplete } = await page.evaluate(() =>
            window.axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] })
        );
        assert.deepEqual(
            violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html)}`),
            []
        );
        assert.deepEqual(
            incomplete
                .filter(({ id }) => id === 'color-contrast')
                .flatMap(({ nodes }) => nodes.map(({ html }) => html)),
            [],
            'contrast of all texts is known'
        );
        if (what === 'phone') {
            const [picture, panel] = [
                await page.locator('#picture').boundingBox(),
                await page.locator('#panel').boundingBox(),
            ];
            assert.ok(picture.y + picture.height <= panel.y + 1, 'the panel does not hide the picture');
            assert.ok(picture.height >= 0.4 * 780, `the picture is ${picture.height} high`);
        }
        await close(viewer);
    });
}

test('the viewer by touch: one finger turns, two come nearer', async () => {
    const viewer = await open('?file=sphere_on_floor.glb', PHONE);
    const { page, drawn } = viewer;
    const touch = await page.context().newCDPSession(page);
    const send = (type, ...points) =>
        touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const view = async () => {
        await page.evaluate(() => document.querySelector('#link').click());
        return cameraOf(new URLSearchParams(await page.evaluate(() => location.hash.slice(1))), {
            width: 390,
            height: 780,
        });
    };
    const before = await view();
    await drawn(async () => {
        await send('touchStart', [200, 400]);
        for (const x of [220, 240, 260]) await send('touchMove', [x, 400]);
        await send('touchEnd');
    });
    const turned = await view();
    assert.ok(distance(turned.forward, before.forward) > 0.05, 'turned');
    await drawn(async () => {
        await send('touchStart', [190, 400], [210, 400]);
        for (const d of [20, 40, 60]) await send('touchMove', [190 - d, 400], [210 + d, 400]);
        await send('touchEnd');
    });
    const nearer = await view();
    assert.ok(distance(nearer.eye, turned.eye) > 0.5 && distance(nearer.forward, turned.forward) < 0.05, 'nearer');
    await close(viewer);
});

test("the viewer's automatic exposure is that of halflight render", async () => {
    for (const name of ['five_lights']) {
        copyFileSync(join(conformance, `${name}.glb`), join(folder, `${name}.glb`));
        const { exposure } = JSON.parse(
            halflight(
                'render',
                join(conformance, `${name}.glb`),
                '-o',
                join(folder, 'render.png'),
                '--size',
                '320x180',
                '--json'
            )
        );
        const viewer = await open(`?file=${name}.glb`, { viewport: { width: 320, height: 180 } });
        const shown = Number((await viewer.text('#exposureValue')).split(' ')[0]);
        console.log(`${name}: ${shown} EV, halflight render ${exposure.toFixed(2)} EV`);
        assert.ok(Math.abs(shown - exposure) < 0.15, `${name}: ${shown} EV instead of ${exposure}`);
        await close(viewer);
    }
});

test('the viewer says in a sentence what is wrong with a file', async () => {
    const viewer = await open('?file=nothing.glb', { drawn: false });
    const { page, drawn, text, says, url } = viewer;
    await says('#message', `nothing.glb was not found on ${new URL(url).host}.`);
    assert.equal(await text('#file'), 'no file open');
    await page.setInputFiles('#open', join(folder, 'plain.glb'));
    await says('#message', 'plain.glb is not a glTF file');
    await page.setInputFiles('#open', join(repository, 'assets/tests/compressed/draco_sequential.glb'));
    await says('#message', 'draco_sequential.glb cannot be shown: its meshes are compressed by Draco');
    // A .gltf with its files beside it.
    const { json, buffer } = readGlb(join(conformance, 'sphere_on_floor.glb'));
    json.buffers[0].uri = 'buffer of it.bin';
    writeFileSync(join(folder, 'parts.gltf'), JSON.stringify(json));
    writeFileSync(join(folder, 'buffer of it.bin'), buffer);
    await page.setInputFiles('#open', join(folder, 'parts.gltf'));
    await says(
        '#message',
        'parts.gltf cannot be shown: buffer of it.bin is missing: drop it together with parts.gltf.'
    );
    await drawn(() =>
        drop(
            page,
            readFileSync,
            ['buffer of it.bin', 'parts.gltf'].map((name) => ({ name, path: join(folder, name) }))
        )
    );
    assert.deepEqual([await text('#file'), await text('#message')], ['parts.gltf', '']);
    await page.setInputFiles('#open', join(folder, 'plain.glb'));
    await says('#message', 'plain.glb is not');
    assert.equal(await text('#file'), 'parts.gltf', 'what was open stays');
    await close(viewer);
    const beside = await open('?file=parts.gltf');
    assert.equal(await beside.text('#message'), '', 'files beside a file with an address');
    await beside.page.route('**/cut.glb', (route) => route.abort());
    await beside.page.evaluate(() => (location.hash = 'file=cut.glb'));
    await beside.says('#message', 'cut.glb cannot be read from');
    await close(beside);
});

test('the viewer leaves out odd parameters with a sentence for each', async () => {
    const viewer = await open(
        '?file=sphere_on_floor.glb&mode=bright&exposure=1e9&distance=-2&fade=&fov=500&camera=none&mod=realtime' +
            '#eye=1,2&view=all&target=1,2,3'
    );
    const notes = await viewer.page.locator('#notes li').allTextContents();
    for (const name of [
        'mode=bright',
        'exposure=1e9',
        'distance=-2',
        'fade=',
        'fov=500',
        'camera=none',
        'eye=1,2',
        'view=all',
        'target=1,2,3',
        'mod',
    ])
        assert.ok(
            notes.some((note) => note.startsWith(`The address has ${name}, which is left out: `)),
            `${name}: ${notes.join(' ')}`
        );
    assert.equal(notes.length, 10);
    assert.equal(await viewer.page.inputValue('#modes input:checked'), 'shadowmask', 'what the file says');
    await close(viewer);
});

test('the viewer says what is wrong when drawing fails, and opens the next file', async () => {
    // A driver that refuses shaders, as where a material has more textures than its fragment shaders can read.
    const viewer = await open('?file=sphere_on_floor.glb', {
        drawn: false,
        script: () => {
            const { shaderSource } = WebGL2RenderingContext.prototype;
            window.refuses = true;
            WebGL2RenderingContext.prototype.shaderSource = function (shader, text) {
                shaderSource.call(
                    this,
                    shader,
                    window.refuses && text.includes('hlReadSurface') ? `${text}\n#error too many textures` : text
                );
            };
        },
    });
    await viewer.says('#message', 'The file cannot be drawn: ');
    assert.equal(await viewer.page.isVisible('#controls'), false);
    await viewer.page.evaluate(() => (window.refuses = false));
    await viewer.choose(join(conformance, 'bumpy_wall.glb'));
    assert.equal(await viewer.text('#message'), '');
    // A driver that stops, and starts again.
    await viewer.page.evaluate(() => {
        const gl = document.querySelector('#picture').getContext('webgl2');
        window.driver = gl.getExtension('WEBGL_lose_context');
        window.driver.loseContext();
    });
    await viewer.says('#message', 'The graphics driver has stopped.');
    await viewer.drawn(() => viewer.page.evaluate(() => window.driver.restoreContext()));
    assert.equal(await viewer.text('#message'), '');
    await close(viewer);
});

test('the viewer says so where there is no WebGL 2', async () => {
    const viewer = await open('', {
        drawn: false,
        script: () => (HTMLCanvasElement.prototype.getContext = () => null),
    });
    await viewer.says('#message', 'This browser has no WebGL 2');
    await viewer.page.close();
});
