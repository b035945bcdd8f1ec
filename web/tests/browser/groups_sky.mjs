// Light groups in what reflection probes show (spec S33), in a sky that changes (S34) and in subtractive shadows, by each
// renderer against the program's pictures and against files that `compose` wrote.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { halflight } from '../harness.mjs';
import { bakeChanged, bakeMetal, optionsOf, setGroups } from './groups_scene.mjs';
import { SIZE, studio } from './studio.mjs';

const RENDERERS = ['webgl', 'webgpu', 'webgl2-nodes'];
const OFF = [0, 0, 0];

/** States of the metal rooms. Parts of the sky are in cd/m2. */
const METAL = {
    saved: {},
    'the lamp alone': { lamp: [1, 2, 4], sun: OFF, west: OFF, east: OFF, 'sky.zenith': OFF, 'sky.horizon': OFF, 'sky.ground': OFF },
    'dusk with a red west': { lamp: OFF, sun: [0.1, 0.05, 0], west: [1, 0.1, 0], east: OFF, 'sky.zenith': [0.1, 0.2, 1], 'sky.horizon': [6, 2, 0.5], 'sky.ground': [0, 0.3, 0] },
};

const recordOf = (name) => readGlb(studio.pathOf(name)).json.extensions.HALFLIGHT_mixed_lighting;

/** A composed file of a state. @returns {string} its name */
function composed(name, label, state) {
    const file = `${name}-${label.replaceAll(' ', '-')}`;
    halflight('compose', studio.pathOf(name), '-o', studio.pathOf(file), '-q', ...optionsOf(state));
    return file;
}

for (const renderer of RENDERERS) {
    test(`groups S33 S34: metal reflects each state, under its sky, ${renderer}`, async () => {
        const name = bakeMetal();
        assert.ok(recordOf(name).groups.some(({ name: group, reflections }) => group === 'west' && reflections.size === 64), 'a picture of half the width');
        const { page, call } = await studio.pageOf('three', renderer);
        await studio.load(call, name);
        for (const [label, state] of Object.entries(METAL)) {
            await setGroups(page, state);
            for (const mode of ['shadowmask', 'realtime']) await studio.compare(call, `metal, ${label}, ${renderer}`, mode, { name, options: optionsOf(state) });
        }
        await setGroups(page, METAL.saved);
        const { camera } = studio.reference(name, 'shadowmask', []);
        const draw = () => call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask' } });
        await draw();
        const saved = await call('picture');
        await setGroups(page, METAL['the lamp alone']);
        await draw();
        const { mean } = await call('agreement', { other: saved });
        assert.ok(mean > 5, `two states differ by ${mean} of 255`);
        await setGroups(page, {});
    });
}

test('groups S33: composeReflections() gives the texels of halflight compose', async () => {
    const name = bakeMetal();
    const { page, call } = await studio.pageOf('three');
    for (const [label, state] of Object.entries(METAL)) {
        const dataOf = async (file) => {
            await call('load', { file: `/files/${file}.glb` });
            return page.evaluateHandle(() => window.halflightPage.loaded.halflight.data);
        };
        const expected = await dataOf(composed(name, label, state));
        const result = await page.evaluate(async ([data, { reflections: expected }, state]) => {
            const { composeReflections } = await import('/web/three/src/file/read.js');
            const { unpackRgb9e5 } = await import('/web/three/src/file/images.js');
            const { kReflectionLevels, reflectionLevelSize, reflectionTileHeight } = await import('/web/three/src/generated/shading.js');
            const { picture, unitNits, size } = composeReflections(data, data.groups.map(({ name, weight }) => state[name] ?? weight));
            let [worst, brightest, texels] = [0, 0, 0];
            const compare = (i) => {
                const [ours, theirs] = [[picture, unitNits], [expected.picture, expected.unitNits]].map(([{ data: words }, unit]) => [0, 1, 2].map((c) => unpackRgb9e5(words[i], c) * unit));
                const most = Math.max(...theirs);
                brightest = Math.max(brightest, most);
                texels += 1;
                for (let c = 0; c < 3; ++c) if (most > 0 || ours[c] > 0) worst = Math.max(worst, Math.abs(ours[c] - theirs[c]) / most);
            };
            for (let probe = 0; probe < data.reflections.probes.length; ++probe)
                for (let level = 0, left = 0; level < kReflectionLevels; ++level) {
                    const width = reflectionLevelSize(size, level);
                    const top = probe * reflectionTileHeight(size) + (level === 0 ? 0 : size);
                    for (let y = 0; y < width; ++y) for (let x = 0; x < width; ++x) compare((top + y) * size + left + x);
                    if (level > 0) left += width;
                }
            return { worst, brightest, texels, same: size === expected.size };
        }, [await dataOf(name), expected, state]);
        console.log(`reflections, ${label}: ${result.texels} texels, apart by ${result.worst.toFixed(5)} at most`);
        assert.ok(result.same && result.texels > 20000 && result.brightest > 0.5, JSON.stringify(result));
        assert.ok(result.worst <= 1 / 256, `${label}, a step of RGB9E5: ${JSON.stringify(result)}`);
    }
});

test('groups S33: a group without a picture of reflections has a sentence, as in the program', async () => {
    const name = 'west-without-a-picture';
    const file = readGlb(studio.pathOf(bakeMetal()));
    const { groups } = file.json.extensions.HALFLIGHT_mixed_lighting;
    delete groups.find((group) => group.name === 'west').reflections;
    writeGlb(studio.pathOf(name), file);
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: `/files/${name}.glb` });
    const said = async (state) => {
        await setGroups(page, state);
        return page.evaluate(() => [...window.halflightPage.loaded.halflight.warnings].filter((s) => s.includes('reflection')));
    };
    assert.deepEqual(await said({ lamp: OFF }), []);
    const [sentence, ...more] = await said({ west: OFF });
    const { warnings } = JSON.parse(halflight('render', studio.pathOf(name), '-o', studio.pathOf('west-off').replace(/glb$/, 'exr'), '--size', '32x18', '--samples', '1', '--json', ...optionsOf({ west: OFF })));
    assert.ok(more.length === 0 && warnings.includes(sentence), `${sentence}; the program: ${warnings.join(' | ')}`);
    assert.deepEqual(await said({}), []);
});

test('groups S34: "sky" stands for all parts of a sky that changes', async () => {
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: `/files/${bakeMetal()}.glb` });
    const { parts, others, refused } = await page.evaluate(() => {
        const { halflight } = window.halflightPage.loaded;
        halflight.setLightGroup('sky', [1, 2, 3]);
        const isPart = ({ name }) => name.startsWith('sky.');
        let refused = '';
        try {
            halflight.setLightGroup('sky.middle', 1);
        } catch (error) {
            refused = error.message;
        }
        return { parts: halflight.lightGroups.filter(isPart), others: halflight.lightGroups.filter((group) => !isPart(group)), refused };
    });
    assert.deepEqual(parts.map(({ name, weight }) => [name, weight]), ['sky.zenith', 'sky.horizon', 'sky.ground'].map((part) => [part, [1, 2, 3]]));
    for (const { weight, savedWeight } of others) assert.deepEqual(weight, savedWeight);
    assert.match(refused, /^there is no light group "sky\.middle": .*: give the scene halflight_sky_changes = 1, and bake it again$/);
});

const skyOf = (zenith, horizon, ground, more) => ({ scenes }) => Object.assign(scenes[0].extras, { halflight_sky_zenith: zenith, halflight_sky_horizon: horizon, halflight_sky_ground: ground, ...more });
const SKIES = {
    'black in red': [skyOf([0, 0.3, 0.5], [0, 0.6, 0.5], [0, 0.1, 0.1], { halflight_sky_group: 'day' }), { day: [1, 0.5, 2] }],
    'black, in a group': [skyOf(OFF, OFF, OFF, { halflight_sky_group: 'day' }), { day: [0.5, 0.3, 0.1] }],
    'black, its parts': [skyOf(OFF, OFF, OFF, { halflight_sky_changes: 1 }), { 'sky.zenith': [0.2, 0.3, 0.9], 'sky.horizon': [0.8, 0.4, 0.2] }],
};
for (const [label, [change, state]] of Object.entries(SKIES))
    for (const renderer of RENDERERS)
        test(`groups S34: a sky that is ${label} shines, ${renderer}`, async () => {
            const name = bakeChanged(`sky-${label.replaceAll(/\W+/g, '-')}`, 'sphere_on_floor', change);
            const { page, call } = await studio.pageOf('three', renderer);
            await studio.load(call, name);
            await setGroups(page, state);
            for (const mode of ['realtime', 'shadowmask']) await studio.compare(call, `sky ${label}, ${renderer}`, mode, { name, options: optionsOf(state) });
            await setGroups(page, {});
        });

/** A ball that moves under a sun; sun and sky are groups. @param {number[]} [author] colour of shadows that the author gave */
const bakeSubtractive = (author) =>
    bakeChanged(`subtractive-groups${author ? '-author' : ''}`, 'sphere_on_floor', ({ scenes, nodes }) => {
        Object.assign(scenes[0].extras, { halflight_sky_group: 'day' }, author && { halflight_shadow_color: author });
        nodes.find((node) => node.name === 'sun').extras.halflight_group = 'sun';
    }, '--mode', 'subtractive', '--subtractive-mask', 'off');

const DAYS = { saved: {}, 'a brighter day': { day: [3, 2, 1] }, 'a low sun': { sun: [1, 0.5, 0.2], day: [0.2, 0.3, 0.5] } };
for (const renderer of RENDERERS)
    test(`groups S33: subtractive shadows follow, ${renderer}`, async () => {
        const name = bakeSubtractive();
        const { page, call } = await studio.pageOf('three', renderer);
        await studio.load(call, name);
        for (const [label, state] of Object.entries(DAYS)) {
            await setGroups(page, state);
            await studio.compare(call, `subtractive, ${label}, ${renderer}`, 'subtractive', { name, options: optionsOf(state) });
        }
        await setGroups(page, {});
    });

test('groups S33: the limit of subtractive shadows is that of halflight compose; the author\'s stays', async () => {
    const { page, call } = await studio.pageOf('three');
    const colorOf = async (name, state) => {
        await studio.load(call, name);
        await setGroups(page, state);
        return page.evaluate(() => [...window.halflightPage.loaded.halflight.shadowColor]);
    };
    const name = bakeSubtractive();
    const colors = [];
    for (const [label, state] of Object.entries(DAYS)) {
        const ours = await colorOf(name, state);
        const theirs = recordOf(composed(name, label, state)).subtractiveShadowColor;
        ours.forEach((x, c) => assert.ok(Math.abs(x - theirs[c]) <= 1e-5 * Math.max(...theirs), `${label}: ${ours}, ${theirs}`));
        colors.push(ours);
    }
    assert.ok(colors[1][0] > 1.2 * colors[0][0], `a brighter day: ${colors}`);
    const author = [0.1, 0.2, 0.3];
    for (const state of Object.values(DAYS)) (await colorOf(bakeSubtractive(author), state)).forEach((x, c) => assert.ok(Math.abs(x - author[c]) < 1e-6, `${x}`));
    const set = await page.evaluate(() => {
        const { halflight } = window.halflightPage.loaded;
        halflight.shadowColor = [1, 2, 3];
        halflight.setLightGroup('day', 0);
        return halflight.shadowColor;
    });
    assert.deepEqual(set, [1, 2, 3], 'that which the application set stays');
    studio.loaded.delete(call);
});
