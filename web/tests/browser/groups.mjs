// Light groups (spec S33): pictures of states by each renderer against the program's, and against files that `compose` wrote.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, realpathSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { halflight, web } from '../harness.mjs';
import { bakeGroups, compose, optionsOf, setGroups, STATES } from './groups_scene.mjs';
import { SIZE, studio } from './studio.mjs';

const RENDERERS = ['webgl', 'webgpu', 'webgl2-nodes'];

for (const renderer of RENDERERS) {
    test(`groups S33: states are those of the program, ${renderer}`, async () => {
        const name = bakeGroups();
        const { page, call } = await studio.pageOf('three', renderer);
        await studio.load(call, name);
        for (const [label, state] of Object.entries(STATES)) {
            await setGroups(page, state);
            await studio.compare(call, `groups, ${label}, ${renderer}`, 'shadowmask', { name, options: optionsOf(state) });
        }
        // The sky by itself, and what it gives objects without probes' light.
        await studio.compare(call, `groups, a bright evening, ${renderer}`, 'realtime', { name, options: optionsOf(STATES['a bright evening']) });
        await setGroups(page, {});
    });
}

for (const renderer of RENDERERS) {
    test(`groups S33: a state is the picture of its composed file, ${renderer}`, async () => {
        const name = bakeGroups();
        const { page, call } = await studio.pageOf('three', renderer);
        for (const label of ['a white lamp alone', 'a bright evening']) {
            const { camera } = studio.reference(name, 'shadowmask', optionsOf(STATES[label]));
            const draw = () => call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask', debugView: 'lit', shadowDistance: 60, shadowFadeRange: 1 } });
            await studio.load(call, compose(name, label));
            await draw();
            const other = await call('picture');
            await studio.load(call, name);
            await setGroups(page, STATES[label]);
            await draw();
            const result = await call('agreement', { other });
            console.log(`${label}, ${renderer}: mean ${result.mean.toFixed(4)} of 255 from the composed file's; ${(100 * result.within).toFixed(2)} % of pixels within 1/255`);
            assert.ok(result.mean <= 0.1 && result.within >= 0.998, JSON.stringify(result));
            await setGroups(page, {});
        }
    });
}

for (const renderer of RENDERERS) {
    test(`groups S33: mean directions of composed light, on metal, ${renderer}`, async () => {
        const name = 'metal-rooms';
        const file = readGlb(studio.pathOf(bakeGroups({ plain: true })));
        for (const material of file.json.materials) Object.assign(material.pbrMetallicRoughness, { metallicFactor: 1, roughnessFactor: 0.35 });
        writeGlb(studio.pathOf(name), file);
        const { page, call } = await studio.pageOf('three', renderer);
        await studio.load(call, name);
        await setGroups(page, STATES['a bright evening']);
        await studio.compare(call, `groups on metal, ${renderer}`, 'shadowmask', { name, options: optionsOf(STATES['a bright evening']) });
        await setGroups(page, {});
    });
}

test('groups S33: composeLight() gives the texels of halflight compose', async () => {
    const name = bakeGroups();
    const label = 'a bright evening';
    const { page, call } = await studio.pageOf('three');
    const dataOf = async (file) => {
        await call('load', { file: `/files/${file}.glb` });
        return page.evaluateHandle(() => window.halflightPage.loaded.halflight.data);
    };
    const composed = await dataOf(compose(name, label));
    const grouped = await dataOf(name);
    const result = await page.evaluate(async ([data, expected, state]) => {
        const { composeLight } = await import('/web/three/src/groups/pages.js');
        const { unpackRgb9e5 } = await import('/web/three/src/file/images.js');
        const { unitLux, lightmaps, directions } = composeLight(data, data.groups.map(({ name, weight }) => state[name] ?? weight));
        let brightest = 0;
        let light = 0;
        let direction = 0;
        lightmaps.forEach(({ data: texels }, page) => texels.forEach((texel, i) => {
            const ours = [0, 1, 2].map((c) => unpackRgb9e5(texel, c) * unitLux);
            const theirs = [0, 1, 2].map((c) => unpackRgb9e5(expected.lightmaps[page].data[i], c) * expected.unitLux);
            const most = Math.max(...theirs);
            brightest = Math.max(brightest, most);
            for (let c = 0; c < 3; ++c) if (most > 0 || ours[c] > 0) light = Math.max(light, Math.abs(ours[c] - theirs[c]) / most);
        }));
        directions.forEach(({ data: texels }, page) => texels.forEach((x, i) => { direction = Math.max(direction, Math.abs(x - expected.directions[page].data[i])); }));
        return { pages: lightmaps.length, directions: directions.length, brightest, light, direction };
    }, [grouped, composed, STATES[label]]);
    assert.ok(result.pages > 1 && result.directions === result.pages && result.brightest > 1, JSON.stringify(result));
    assert.ok(result.light <= 1 / 256 && result.direction <= 1, `a step of RGB9E5, and of a direction: ${JSON.stringify(result)}`);
});

for (const renderer of RENDERERS) {
    test(`groups S33: more groups than one draw adds, ${renderer}`, async () => {
        const name = 'each-light';
        studio.bake('tests/thirteen_lights', name, '--groups', 'each', '--directional', 'on', '--texels-per-meter', '5', '--probe-spacing', '1.3', '--samples', '16');
        const { groups } = JSON.parse(halflight('info', '--json', studio.pathOf(name)));
        assert.ok(groups.length > 8, `${groups.length} groups`);
        const { page, call } = await studio.pageOf('three', renderer);
        await studio.load(call, name);
        const state = Object.fromEntries(groups.map((group, i) => [group.name, [0, 1, 2].map((c) => ((7 * i + 3 * c) % 5) / 2)]));
        await setGroups(page, state);
        await studio.compare(call, `thirteen groups, ${renderer}`, 'shadowmask', { name, options: optionsOf(state) });
        await setGroups(page, {});
    });
}

test('groups S33: the processor adds pages up where the browser draws into no half floats', async () => {
    const name = bakeGroups();
    const label = 'a bright evening';
    const { page, call } = await studio.pageOf('three');
    await page.evaluate(() => {
        const own = (window.ownGetExtension = WebGL2RenderingContext.prototype.getExtension);
        WebGL2RenderingContext.prototype.getExtension = function (name) {
            return name.startsWith('EXT_color_buffer') ? null : own.call(this, name);
        };
    });
    await call('load', { file: `/files/${name}.glb` });
    await call('draw', { width: 32, height: 18, camera: 'main', settings: { mode: 'shadowmask' } });
    await page.evaluate(() => (WebGL2RenderingContext.prototype.getExtension = window.ownGetExtension));
    const kind = await page.evaluate(() => window.halflightPage.loaded.halflight.backend.composer.constructor.name);
    assert.equal(kind, 'ProcessorPages');
    await studio.compare(call, 'groups by the processor, saved', 'shadowmask', { name, options: optionsOf({}) });
    await setGroups(page, STATES[label]);
    await studio.compare(call, `groups by the processor, ${label}`, 'shadowmask', { name, options: optionsOf(STATES[label]) });
    await call('load', { file: '/assets/conformance/sphere_on_floor.glb' });
});

const transform = join(web, 'node_modules/.bin/gltf-transform');
const tools = {
    'halflight optimize': (from, to) => halflight('optimize', from, to),
    'gltf-transform optimize': (from, to) => execFileSync(process.execPath, [realpathSync(transform), 'optimize', from, to, '--config', join(web, 'gltf-transform/halflight.config.mjs')], { stdio: 'pipe' }),
};
for (const [tool, run] of Object.entries(tools)) {
    test(`groups S33: a file keeps its groups in ${tool}`, { skip: tool.startsWith('gltf') && !existsSync(transform) ? 'the npm package @gltf-transform/cli is not installed' : false }, async () => {
        const name = bakeGroups();
        const label = 'a bright evening';
        const small = `groups-by-${tool.replaceAll(' ', '-')}`;
        run(studio.pathOf(name), studio.pathOf(small));
        const { page, call } = await studio.pageOf('three');
        const { bytes } = await studio.load(call, small);
        assert.ok(bytes.groups > 1000, `${bytes.groups} bytes of groups`);
        await setGroups(page, STATES[label]);
        const { camera, url } = studio.reference(name, 'shadowmask', ['--shadow-distance', '60', '--shadow-fade-range', '1', ...optionsOf(STATES[label])]);
        await studio.compareWith(call, `groups, ${tool}`, { reference: url, camera, size: SIZE, settings: { debugView: 'lit', mode: 'shadowmask', shadowDistance: 60, shadowFadeRange: 1 } });
        await setGroups(page, {});
    });
}
