// A light that turns (spec S34): its bounced light follows its direction, by each renderer, as the program's does.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { halflight } from '../harness.mjs';
import { bakeChanged } from './groups_scene.mjs';
import { SIZE, studio } from './studio.mjs';

const RENDERERS = ['webgl', 'webgpu', 'webgl2-nodes'];

/** The sun of the rooms, turned about the vertical by degrees, along which it shines. */
function sunlight(degrees) {
    const [x, y, z, w] = [-0.30639284, 0.21807073, 0.07232954, 0.92376243]; // the node's rotation, of -Z
    const along = [-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))];
    const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    return [c * along[0] + s * along[2], along[1], c * along[2] - s * along[0]];
}

/** The rooms under a sun of three directions. @returns {string} name of the baked file */
const bakeTurning = () =>
    bakeChanged('turning-sun', 'light_groups', ({ nodes }) => {
        nodes.find(({ name }) => name === 'sun').extras = { halflight_mode: 'mixed', halflight_directions: [-18, 0, 18].map(sunlight) };
    }, '--texels-per-meter', '5', '--probe-layout', 'grid', '--probe-spacing', '1.3', '--samples', '16', '--reflection-probes', 'off');

/** Turns the page's sun. @param {number[]} along in the file */
const turn = (page, along) =>
    page.evaluate(([x, y, z]) => {
        const { light } = window.halflightPage.loaded.halflight.lights.find(({ name }) => name === 'sun');
        const from = light.position.clone().set(0, 0, -1);
        const toParent = light.quaternion.clone().identity();
        light.parent.getWorldQuaternion(toParent);
        light.quaternion.setFromUnitVectors(from, light.position.clone().set(x, y, z)).premultiply(toParent.invert());
    }, along);

const settings = { mode: 'shadowmask', shadowDistance: 60, shadowFadeRange: 1 };

for (const renderer of RENDERERS)
    test(`groups S34: bounced light of a sun that was turned is that of its composed file, ${renderer}`, async () => {
        const name = bakeTurning();
        const { page, call } = await studio.pageOf('three', renderer);
        const { camera } = studio.reference(name, 'shadowmask', []);
        const draw = () => call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { ...settings, debugView: 'lightmap' } });
        const along = sunlight(-7);
        const composed = 'turning-sun-between';
        halflight('compose', studio.pathOf(name), '-o', studio.pathOf(composed), '-q', '--light', `sun:direction=${along.join(',')}`);
        await studio.load(call, composed);
        await draw();
        const other = await call('picture');
        await studio.load(call, name);
        await draw();
        const before = await call('agreement', { other });
        assert.ok(before.mean > 1, `the light is another one before the sun turns: ${JSON.stringify(before)}`);
        await turn(page, along);
        await draw();
        const result = await call('agreement', { other });
        console.log(`turned sun, ${renderer}: mean ${result.mean.toFixed(4)} of 255 from the composed file's; ${before.mean.toFixed(2)} before`);
        assert.ok(result.mean <= 0.1 && result.within >= 0.998, JSON.stringify(result));
        await studio.compare(call, `turned sun, ${renderer}`, 'shadowmask', { name, options: ['--light', `sun:direction=${along.join(',')}`] });
    });

test('groups S34: a sun that turns is one group, named as its light; others of its directions are refused', async () => {
    const { page, call } = await studio.pageOf('three');
    await studio.load(call, bakeTurning());
    const { groups, refused, color } = await page.evaluate(() => {
        const { halflight } = window.halflightPage.loaded;
        let refused = '';
        try {
            halflight.setLightGroup('sun.2', 1);
        } catch (error) {
            refused = error.message;
        }
        halflight.setLightGroup('sun', [0.5, 0.25, 0]);
        const { light } = halflight.lights.find(({ name }) => name === 'sun');
        return { groups: halflight.lightGroups, refused, color: light.color.toArray().map((x) => x * light.intensity) };
    });
    const [sun, ...more] = groups.filter(({ name }) => name.startsWith('sun'));
    assert.deepEqual([sun.name, sun.weight, more], ['sun', [0.5, 0.25, 0], []]);
    for (const [c, x] of [20, 10, 0].entries()) assert.ok(Math.abs(color[c] - x) < 1e-3, `${color}`);
    assert.equal(refused, 'light group "sun.2" is of one direction of a light and follows it: turn the light, or set "sun"');
});
