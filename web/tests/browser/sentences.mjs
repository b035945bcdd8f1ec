// Nothing is silent: what an application does that the bake does not follow is a sentence, while it is so.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { studio } from './studio.mjs';

const FILE = '/assets/conformance/five_lights.glb';

/** Each cause: what is done to the page's file, its sentence, and how it is taken back. Functions run in the page. */
const CAUSES = [
    ['another material', /^"floor" got another material, "mine", which does not show the bake/,
        ({ THREE, loaded, mesh }) => { loaded.kept = mesh('floor').material; mesh('floor').material = new THREE.MeshStandardMaterial({ name: 'mine' }); },
        ({ loaded, mesh }) => { mesh('floor').material = loaded.kept; }],
    ['a cloned material', /^"floor" got another material/,
        ({ loaded, mesh }) => { loaded.kept = mesh('floor').material; mesh('floor').material = loaded.kept.clone(); },
        ({ loaded, mesh }) => { mesh('floor').material = loaded.kept; }],
    ['a material of another kind', /^material "lambert" of "floor" is a MeshLambertMaterial/,
        ({ THREE, loaded, mesh }) => { loaded.kept = mesh('floor').material; mesh('floor').material = new THREE.MeshLambertMaterial({ name: 'lambert' }); },
        ({ loaded, mesh }) => { mesh('floor').material = loaded.kept; }],
    ['a static object that moved', /^static object "box_1" moved since its bake/,
        ({ mesh }) => { mesh('box_1').position.x += 0.5; },
        ({ mesh }) => { mesh('box_1').position.x -= 0.5; }],
    ['a static object that grew', /^static object "box_1" moved since its bake/,
        ({ mesh }) => mesh('box_1').scale.setScalar(2),
        ({ mesh }) => mesh('box_1').scale.setScalar(1)],
    ['a brighter light', /^light "point_1" changed since its bake: its bounced light stays/,
        ({ loaded }) => { loaded.halflight.lights[0].light.intensity *= 2; },
        ({ loaded }) => { loaded.halflight.lights[0].light.intensity /= 2; }],
    ['a light of another colour', /^light "point_1" changed/,
        ({ loaded }) => { loaded.kept = loaded.halflight.lights[0].light.color.clone(); loaded.halflight.lights[0].light.color.set(0x0000ff); },
        ({ loaded }) => loaded.halflight.lights[0].light.color.copy(loaded.kept)],
    ['a light that is off', /^light "point_1" changed/,
        ({ loaded }) => { loaded.halflight.lights[0].light.visible = false; },
        ({ loaded }) => { loaded.halflight.lights[0].light.visible = true; }],
    ['a light that moved', /^light "point_1" moved since its bake/,
        ({ loaded }) => { loaded.halflight.lights[0].light.position.x += 0.3; },
        ({ loaded }) => { loaded.halflight.lights[0].light.position.x -= 0.3; }],
    ['a scale by axis', /is scaled by axis or sheared/,
        ({ loaded }) => loaded.gltf.scene.scale.set(1, 2, 1),
        ({ loaded }) => loaded.gltf.scene.scale.set(1, 1, 1)],
];

for (const renderer of ['webgl', 'webgpu']) {
    test(`sentences: each cause has one, while it is there, ${renderer}`, async () => {
        const { page, call } = await studio.pageOf('three', renderer);
        await call('load', { file: FILE });
        const causes = CAUSES.map(([name, , begin, end]) => [name, begin.toString(), end.toString()]);
        const results = await page.evaluate(async (list) => {
            const { loaded, makeRenderer, viewOf, THREE } = window.halflightPage;
            const r = await makeRenderer(64, 36);
            const said = [];
            const warn = console.warn;
            console.warn = (text) => said.push(String(text));
            const view = viewOf('main', 16 / 9);
            const page = { THREE, loaded, mesh: (name) => loaded.gltf.scene.getObjectByName(name) };
            const frame = () => { loaded.halflight.update(r, view); return [...loaded.halflight.warnings]; };
            const result = [{ before: frame() }];
            for (const [, begin, end] of list) {
                said.length = 0;
                (0, eval)(`(${begin})`)(page);
                const there = [frame(), frame()];
                const spoken = said.splice(0);
                (0, eval)(`(${end})`)(page);
                result.push({ there, spoken, after: frame() });
            }
            console.warn = warn;
            return result;
        }, causes);
        assert.deepEqual(results[0].before, []);
        const heard = new Set();
        CAUSES.forEach(([name, sentence], i) => {
            const { there, spoken, after } = results[i + 1];
            for (const list of there) assert.ok(list.length === 1 && sentence.test(list[0]), `${name}: ${list.join(' | ')}`);
            assert.equal(spoken.filter((text) => text.endsWith(there[0][0])).length, heard.has(there[0][0]) ? 0 : 1, `${name}: once on the console`);
            heard.add(there[0][0]);
            assert.deepEqual(after, [], `${name}: its sentence goes with it`);
        });
    });

    test(`sentences: frames before update(), lost bakes, plain files, ${renderer}`, async () => {
        const { page, call } = await studio.pageOf('three', renderer);
        await call('load', { file: FILE });
        const result = await page.evaluate(async (file) => {
            const { loaded, makeRenderer, viewOf, THREE, GLTFLoader, HalflightPlugin } = window.halflightPage;
            const r = await makeRenderer(64, 36);
            const said = [];
            const warn = console.warn;
            console.warn = (text) => said.push(String(text));
            const view = viewOf('main', 16 / 9);
            r.render(loaded.scene, view);
            r.render(loaded.scene, view);
            const early = { said: said.splice(0), warnings: [...loaded.halflight.warnings] };
            loaded.halflight.update(r, view);
            r.render(loaded.scene, view);
            const later = { said: said.splice(0), warnings: [...loaded.halflight.warnings] };
            const loader = new GLTFLoader();
            loader.register((parser) => new HalflightPlugin(parser));
            const bytes = new Uint8Array(await (await fetch(file)).arrayBuffer());
            const length = new DataView(bytes.buffer).getUint32(12, true);
            const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
            const scenes = json.scenes.map(({ name, extras }) => ({ name, extras }));
            const plain = JSON.stringify({ asset: { version: '2.0' }, scenes: [{ name: 'plain' }], scene: 0 });
            const none = (await loader.parseAsync(plain, '')).userData.halflight;
            const ofPlain = said.splice(0);
            await loader.parseAsync(JSON.stringify({ asset: { version: '2.0' }, scenes, scene: 0 }), '');
            const ofLost = said.splice(0);
            console.warn = warn;
            return { early, later, none, ofPlain, ofLost };
        }, FILE);
        assert.equal(result.early.said.length, 1);
        assert.match(result.early.said[0], /update\(\) was not called before a frame/);
        assert.equal(result.early.warnings.length, 1);
        assert.deepEqual(result.later, { said: [], warnings: [] });
        assert.equal(result.none, null);
        assert.deepEqual(result.ofPlain, []);
        assert.equal(result.ofLost.length, 1);
        assert.match(result.ofLost[0], /the file was baked, but a tool dropped the bake/);
    });
}

test('sentences: probes without tetrahedra, as older bakes wrote them', async () => {
    const file = readGlb(studio.pathOf('conformance/five_lights'));
    const { probes } = file.json.extensions.HALFLIGHT_mixed_lighting;
    delete probes.tetrahedra;
    delete probes.neighbors;
    writeGlb(studio.pathOf('without-tetrahedra'), file);
    const { call } = await studio.pageOf('three');
    await studio.load(call, 'without-tetrahedra');
    const { warnings } = await call('draw', { width: 32, height: 18, camera: 'main' });
    assert.ok(warnings.some((sentence) => /has no tetrahedra .* light of the nearest probe; bake the scene again$/.test(sentence)), warnings.join());
});

test('sentences: setters refuse what is no number, and update() throws once', async () => {
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: FILE });
    const { refused, thrown, kept } = await page.evaluate(() => {
        const { loaded, viewOf } = window.halflightPage;
        const { halflight } = loaded;
        const refused = [];
        const attempt = (object, key, value) => {
            try {
                object[key] = value;
                refused.push(`${key} = ${value} was taken`);
            } catch (error) {
                if (!error.message.includes(key)) refused.push(error.message);
            }
        };
        for (const value of [NaN, Infinity, -1, '3', null, undefined])
            for (const key of ['shadowDistance', 'shadowFadeRange']) attempt(halflight, key, value);
        for (const value of [[1, 2], [1, NaN, 3], null, ['1', 2, 3]]) attempt(halflight, 'shadowColor', value);
        for (const value of [NaN, 2, -0.5, '1']) attempt(halflight.lights[0], 'shadowStrength', value);
        for (const value of [1, 'no', null]) attempt(halflight.lights[0], 'castShadows', value);
        const thrown = [];
        for (let i = 0; i < 3; ++i)
            try {
                halflight.update({}, viewOf('main', 1));
            } catch (error) {
                thrown.push(error.message);
            }
        return { refused, thrown, kept: [halflight.shadowDistance, halflight.shadowFadeRange, halflight.lights[0].shadowStrength] };
    });
    assert.deepEqual(refused, []);
    assert.equal(thrown.length, 1);
    assert.match(thrown[0], /import the plug-in from/);
    assert.deepEqual(kept, [60, 1, 1]);
});

for (const renderer of ['webgl', 'webgpu']) {
    test(`sentences: another release of three.js, ${renderer}`, async () => {
        const page = await studio.newPage();
        await page.route('**/three/build/three.core.js', async (route) => {
            const response = await route.fetch();
            await route.fulfill({ response, body: (await response.text()).replace(/const REVISION = '\d+'/, "const REVISION = '150'") });
        });
        await page.goto(`${await studio.urlOf('three')}/web/tests/page/${renderer === 'webgl' ? 'index' : 'webgpu'}.html?renderer=${renderer}`);
        await page.waitForFunction('window.ready === true');
        const sentence = await page.evaluate(() => {
            try {
                new window.halflightPage.HalflightPlugin({});
                return 'none';
            } catch (error) {
                return error.message;
            }
        });
        await page.close();
        assert.match(sentence, /^Halflight works with three.js 0.183 to 0.187; this page has 0.150, whose shaders may differ$/);
    });
}
