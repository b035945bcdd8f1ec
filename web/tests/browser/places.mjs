// A file under any parent, mirrored ones too, and its clones: each picture is that of the file where it was loaded, and the program's.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { halflight, repository } from '../harness.mjs';
import { writeSky } from '../pictures.mjs';
import { studio } from './studio.mjs';

const SMALL = [160, 90];
const SHADOW = ['--shadow-distance', '60', '--shadow-fade-range', '1'];
const PLACES = {
    moved: { translation: [20, 3, -7] },
    turned: { rotation: [0.3, 1.1, -0.2], translation: [-4, 1, 2] },
    'ten times as large': { scale: 10, rotation: [0, 2, 0] },
    'a fifth as large': { scale: 0.2, translation: [5, 0, 0] },
};
const MIRRORED = { scale: [-1, 1, 1], rotation: [0.3, 1.1, -0.2], translation: [3, 1, 2] };
// Lights of each kind with ranges, a sky's picture, and objects that probes light.
const SETTINGS = `
[sky]
image = "sky.hdr"
rotation = 25
[[add_light]]
type = "rectangle"
name = "window"
size = [1.5, 1]
position = [-2, 2.2, 1]
direction = [1, -1, -0.3]
intensity = 2
range = 9
[[add_light]]
type = "spot"
name = "lamp"
position = [1.5, 2.5, 1.5]
direction = [-0.4, -1, -0.4]
outer_cone_degrees = 40
intensity = 6
range = 7
`;

function bakeAll() {
    writeSky(join(studio.files, 'sky.hdr'));
    const settings = join(studio.files, 'places.toml');
    writeFileSync(settings, SETTINGS);
    studio.bake('tests/sphere_on_floor', 'places', '--settings', settings);
    return 'places';
}

/** The wall of the bumps, whose normals are a texture's, mirrored by its own scale. */
function bakeMirroredWall() {
    const name = 'mirrored-wall';
    const source = readGlb(join(repository, 'assets/tests/bumpy_wall.glb'));
    source.json.nodes.find((node) => node.name === 'wall').scale = [-1, 1, 1];
    writeGlb(studio.pathOf(`${name}-source`), source);
    halflight('bake', studio.pathOf(`${name}-source`), '-o', studio.pathOf(name), '--quality', 'preview', '--directional', 'on', '-q');
    return name;
}

async function intensitiesOf(call) {
    const names = await call('lightNames');
    return Promise.all(names.map((_, index) => call('intensityOf', { index })));
}

/** Pictures of a file in its place and elsewhere are the same, and the program's. */
async function compareElsewhere(renderer, name, mode, where, label) {
    const { call } = await studio.pageOf('three', renderer);
    await studio.load(call, name);
    await studio.compare(call, `${name}, ${renderer}`, mode, { name, size: SMALL });
    const original = await call('picture');
    const intensities = await intensitiesOf(call);
    await call('put', where);
    // Nothing tells the plug-in of copies in a scene that the file is not in, before they are drawn once.
    if (where.copy === 'drei' && where.alone) await call('draw', { width: SMALL[0], height: SMALL[1], camera: studio.reference(name, mode, SHADOW, SMALL).camera });
    const { warnings } = await studio.compare(call, `${label}, ${name}, ${renderer}`, mode, { name, size: SMALL });
    const { mean, within } = await call('agreement', { other: original });
    console.log(`${label}, ${name}, ${mode}, ${renderer}: ${mean.toFixed(4)} of 255 from where it was loaded, ${(100 * within).toFixed(2)} % within 1`);
    assert.ok(mean <= 0.1 && within >= 0.995, `${label}: ${mean} of 255, ${within} within 1`);
    assert.deepEqual(await intensitiesOf(call), intensities, 'as the application reads them');
    assert.deepEqual(warnings.filter((sentence) => /moved|scale/.test(sentence)), []);
}

test('places: clones have no sky of their own, as it is no part of the file', async () => {
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: '/assets/conformance/sphere_on_floor.glb' });
    await call('put', { ...PLACES.moved, copy: 'clone' });
    const skies = await page.evaluate(async () => {
        const { loaded, makeRenderer, viewOf } = window.halflightPage;
        loaded.halflight.update(await makeRenderer(32, 18), viewOf('main', 16 / 9));
        const all = [];
        loaded.scene.traverse((object) => object.name === 'halflight sky' && all.push(object.parent === loaded.scene));
        return all;
    });
    assert.deepEqual(skies, [true], 'one, a child of the scene');
});

for (const renderer of ['webgl', 'webgpu']) {
    for (const [label, where] of Object.entries(PLACES)) {
        test(`places: ${label}, ${renderer}`, async () => {
            const name = bakeAll();
            for (const mode of renderer === 'webgl' ? ['shadowmask', 'realtime'] : ['shadowmask']) await compareElsewhere(renderer, name, mode, where, label);
        });
    }
    test(`places: masks of point lights, proxy volumes and reflection boxes, ${renderer}`, async () => {
        studio.bake('tests/two_rooms', 'two-rooms');
        for (const name of ['conformance/five_lights', 'conformance/proxy_volume', 'two-rooms']) await compareElsewhere(renderer, name, 'shadowmask', { ...PLACES.turned, scale: 3 }, 'turned and larger');
    });
    test(`places: mirrored, with normals by texture and tangents, ${renderer}`, async () => {
        for (const name of ['conformance/bumpy_wall', 'conformance/five_lights']) await compareElsewhere(renderer, name, 'shadowmask', MIRRORED, 'mirrored');
        const { call } = await studio.pageOf('three', renderer);
        const name = bakeMirroredWall();
        await studio.load(call, name);
        await studio.compare(call, `a mirrored object, ${renderer}`, 'shadowmask', { name, size: SMALL });
    });
    for (const copy of ['clone', 'skeleton', 'drei']) {
        test(`places: a clone by ${copy}, ${renderer}`, async () => {
            await compareElsewhere(renderer, 'conformance/five_lights', 'shadowmask', { ...PLACES.moved, copy }, `beside, ${copy}`);
            await compareElsewhere(renderer, 'conformance/five_lights', 'shadowmask', { ...PLACES.turned, copy, alone: true }, `alone, ${copy}`);
            // The sun, a spot light and an area light: clones have to aim as their originals.
            const modes = renderer === 'webgl' ? ['shadowmask', 'realtime'] : ['shadowmask'];
            for (const mode of modes) await compareElsewhere(renderer, bakeAll(), mode, { ...PLACES.turned, copy, alone: true }, `alone, ${copy}`);
        });
    }
    test(`places: objects of one mesh by a loader whose associations they share, ${renderer}`, async () => {
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'conformance/five_lights', { shareAssociations: true });
        await studio.compare(call, `shared associations, ${renderer}`, 'shadowmask', { name: 'conformance/five_lights', size: SMALL });
    });
}
