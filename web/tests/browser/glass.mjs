// Glass that three.js draws as the program does (spec S35): panes of halflight_tinted and of KHR_materials_transmission.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';

import { bakeChanged } from './groups_scene.mjs';
import { studio } from './studio.mjs';

const SIZE = [160, 90];
/** Of assets/tests/coloured_glass.glb: base colours, and what passes: 1 - alpha of the film, 0.96 of the pane. */
const PASSED = { film: [0.9, 0.1, 0.05].map((c) => 0.8 * c), pane: [0.1, 0.25, 0.9].map((c) => 0.96 * c) };

const bake = () =>
    bakeChanged('panes', 'coloured_glass', ({ nodes, scenes }) => {
        const block = nodes.findIndex(({ name }) => name === 'block'); // glass with a volume has three.js's own pass
        scenes[0].nodes = scenes[0].nodes.filter((node) => node !== block);
    }, '--texels-per-meter', '4', '--samples', '16', '--reflection-probes', 'off');

/** Light through a pane: what a bright board behind it adds to the picture, over what the board is without the pane. */
function shares({ name }) {
    const { THREE, loaded, draw } = window.halflightPage;
    const place = { film: -1.4, pane: 0 }[name];
    const board = new THREE.Mesh(new THREE.PlaneGeometry(0.6, 0.6), new THREE.MeshBasicMaterial({ toneMapped: false }));
    board.position.set(2.6, 1.6, place);
    board.rotation.y = -Math.PI / 2;
    loaded.scene.add(board);
    const glass = loaded.gltf.scene.getObjectByName(name);
    const camera = { fov: 40, eye: [0.3, 1.6, place], target: [2.6, 1.6, place] };
    const center = async (nits, visible) => {
        board.material.color.setRGB(...nits);
        glass.visible = visible;
        await draw({ width: 48, height: 27, camera, settings: { mode: 'shadowmask', debugView: 'lit' } });
        return [...loaded.picture.rows.slice(3 * (13 * 48 + 24), 3 * (13 * 48 + 24) + 3)];
    };
    const drawn = async () => {
        const [dark, bright] = [await center([0, 0, 0], true), await center([40, 30, 20], true)];
        const bare = await center([40, 30, 20], false);
        loaded.scene.remove(board);
        glass.visible = true;
        return { through: bright.map((x, c) => (x - dark[c]) / bare[c]), own: dark };
    };
    return drawn();
}

for (const renderer of ['webgl', 'webgpu', 'webgl2-nodes']) {
    test(`glass S35: panes let their colour through, ${renderer}`, async () => {
        bake();
        const { page, call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'panes');
        for (const [name, right] of Object.entries(PASSED)) {
            const { through, own } = await page.evaluate(shares, { name });
            right.forEach((share, c) => assert.ok(Math.abs(through[c] - share) < 0.004, `${renderer}, ${name}: ${through} for ${right}`));
            if (name === 'film') assert.ok(own[0] > 0.05, 'and has light of its own');
        }
    });

    test(`glass S35: the room with panes is the program's, ${renderer}`, async () => {
        bake();
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'panes');
        await studio.compare(call, `panes, ${renderer}`, 'shadowmask', { name: 'panes', size: SIZE });
    });
}

test("glass S35: glass of the application is three.js's", async () => {
    bake();
    const { page, call } = await studio.pageOf('three', 'webgl');
    await studio.load(call, 'panes');
    const [transmission, transparent] = await page.evaluate(async () => {
        const { THREE, loaded, draw } = window.halflightPage;
        const own = new THREE.Mesh(new THREE.SphereGeometry(0.2), new THREE.MeshPhysicalMaterial({ transmission: 0.8 }));
        own.position.set(0.5, 0.8, -1);
        loaded.scene.add(own);
        loaded.halflight.add(own);
        await draw({ width: 32, height: 18, camera: { fov: 57, eye: [-1.4, 1.7, 2.2], target: [0.5, 0.8, -1] } });
        loaded.halflight.remove(own);
        loaded.scene.remove(own);
        return [own.material.transmission, own.material.transparent];
    });
    assert.deepEqual([transmission, transparent], [0.8, false]);
});

test('glass S35: dispose() gives materials back', async () => {
    bake();
    for (const renderer of ['webgl', 'webgpu']) {
        const { page, call } = await studio.pageOf('three', renderer);
        await call('load', { file: '/files/panes.glb' });
        const states = await page.evaluate(async () => {
            const { loaded, draw } = window.halflightPage;
            const names = ['transparent', 'depthWrite', 'blending', 'transmission'];
            const state = () => ['film', 'pane'].map((name) => names.map((key) => loaded.gltf.scene.getObjectByName(name).material[key]));
            const before = state();
            const camera = { fov: 57, eye: [-1.4, 1.7, 2.2], target: [0.5, 0.8, -1] };
            await draw({ width: 32, height: 18, camera });
            const during = state();
            loaded.halflight.dispose();
            return [before, during, state()];
        });
        assert.deepEqual(states[2], states[0], renderer);
        assert.notDeepEqual(states[1], states[0], renderer);
    }
});
