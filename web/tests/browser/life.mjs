// What the plug-in makes goes with it: graphics memory after loads, and objects that leave.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { studio } from './studio.mjs';

const renderers = ['webgl', 'webgpu'];

for (const renderer of renderers) {
    test(`life: dispose() frees all that the plug-in made, ${renderer}`, async () => {
        studio.bake('tests/sphere_on_floor', 'life', '--lightmap-size', '64');
        const { page } = await studio.pageOf('three', renderer);
        const memory = await page.evaluate(async () => {
            const { loaded, load, makeRenderer, viewOf } = window.halflightPage;
            const r = await makeRenderer(32, 18);
            const counts = [];
            for (let i = 0; i < 10; ++i) {
                await load({ file: '/files/life.glb' });
                const { halflight, scene } = loaded;
                for (const { light } of halflight.lights) light.shadow?.mapSize.setScalar(64);
                scene.add(loaded.gltf.scene.clone());
                halflight.mode = 'distance-shadowmask';
                halflight.update(r, viewOf('main', 16 / 9));
                r.render(scene, viewOf('main', 16 / 9));
                const during = r.info.memory.textures;
                const geometries = new Set();
                scene.traverse((o) => {
                    if (!o.isMesh || o === halflight.sky) return;
                    geometries.add(o.geometry); // materials stay, and with them their compiled programs
                });
                halflight.dispose();
                halflight.update(r, viewOf('main', 16 / 9));
                for (const own of geometries) own.dispose();
                scene.traverse((o) => o.isLight && o.dispose());
                counts.push({ during, textures: r.info.memory.textures, geometries: r.info.memory.geometries, marked: loaded.gltf.scene.getObjectByName('floor').userData.halflight !== undefined });
            }
            loaded.halflight = null;
            return counts;
        });
        const [first] = memory;
        const last = memory.at(-1);
        assert.ok(first.during > first.textures, 'the plug-in had textures');
        assert.equal(last.textures, first.textures, JSON.stringify(memory));
        assert.equal(last.geometries, first.geometries, JSON.stringify(memory));
        assert.ok(!last.marked, 'no mark is left');
    });
}

for (const renderer of renderers) {
    test(`life: remove(), and objects that leave the scene, ${renderer}`, async () => {
        studio.bake('tests/sphere_on_floor', 'life', '--lightmap-size', '64');
        const { page, call } = await studio.pageOf('three', renderer);
        await call('load', { file: '/files/life.glb' });
        const result = await page.evaluate(async () => {
            const { THREE, loaded, makeRenderer, viewOf } = window.halflightPage;
            const r = await makeRenderer(32, 18);
            const { halflight, scene, gltf } = loaded;
            const view = viewOf('main', 16 / 9);
            const update = () => { halflight.update(r, view); return halflight.objects.length; };
            const hooks = (material) => ['onBeforeCompile', 'setupLightingModel'].some((name) => Object.hasOwn(material, name));
            const before = update();
            const own = [0, 1, 2].map((x) => {
                const mesh = new THREE.Mesh(new THREE.SphereGeometry(0.1), new THREE.MeshStandardMaterial());
                mesh.position.set(x, 1, 0);
                halflight.add(mesh);
                return mesh;
            });
            const early = update(); // not in the scene yet
            scene.add(...own);
            const added = update();
            const patched = own.map((mesh) => hooks(mesh.material));
            halflight.remove(own[0]);
            const removed = update();
            scene.remove(own[1]);
            const dropped = update();
            const left = own.map((mesh) => hooks(mesh.material));
            const rows = halflight.table.count;
            for (let i = 0; i < 50; ++i) {
                const copy = gltf.scene.clone();
                scene.add(copy);
                update();
                scene.remove(copy);
                update();
            }
            return { before, early, added, removed, dropped, patched, left, last: update(), rows, grown: halflight.table.count, instances: halflight.members.instances.size };
        });
        const { before } = result;
        assert.deepEqual([result.early, result.added, result.removed, result.dropped, result.last], [before + 3, before + 3, before + 2, before + 1, before + 1]);
        assert.deepEqual(result.patched, [true, true, true]);
        assert.deepEqual(result.left, [false, false, true]);
        assert.equal(result.instances, 1);
        assert.ok(result.grown - result.rows <= 10, `rows are used again: ${result.rows} to ${result.grown}`);
    });
}

test('life: only objects that moved in their file are lit anew', async () => {
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: '/assets/conformance/five_lights.glb' });
    const counts = await page.evaluate(async () => {
        const { THREE, loaded, makeRenderer, viewOf } = window.halflightPage;
        const r = await makeRenderer(32, 18);
        const { halflight, scene, gltf } = loaded;
        const { field } = halflight;
        const view = viewOf('main', 16 / 9);
        const material = new THREE.MeshStandardMaterial();
        const own = Array.from({ length: 300 }, (_, i) => {
            const mesh = new THREE.Mesh(new THREE.SphereGeometry(0.1, 4, 2), material);
            mesh.position.set((i % 20) * 0.2 - 2, 0.5, Math.floor(i / 20) * 0.2 - 1.5);
            gltf.scene.add(mesh);
            halflight.add(mesh);
            return mesh;
        });
        const sample = field.sample;
        let count = 0;
        field.sample = function (...values) { count += 1; return sample.apply(this, values); };
        const frame = (change) => { change(); count = 0; halflight.update(r, view); return count; };
        const move = (n) => own.slice(0, n).forEach((mesh) => { mesh.position.x += 0.01; });
        const result = {
            first: frame(() => {}), all: frame(() => move(300)), some: frame(() => move(30)), none: frame(() => {}),
            file: frame(() => { gltf.scene.position.x += 5; }), turned: frame(() => { gltf.scene.rotation.y += 1; }),
        };
        const rows = own.map((mesh) => halflight.members.rows.get(mesh));
        const light = () => rows.map((row) => [...halflight.table.texture.image.data.subarray(halflight.table.at(row, 2), halflight.table.at(row, 12))]);
        const inTurn = light();
        own.reverse().forEach((mesh) => { mesh.position.y += 1; });
        halflight.update(r, view);
        own.reverse().forEach((mesh) => { mesh.position.y -= 1; });
        halflight.update(r, view);
        const again = light();
        result.apart = Math.max(...inTurn.flatMap((list, i) => list.map((x, k) => Math.abs(x - again[i][k]) / (1e-6 + Math.abs(x)))));
        field.sample = sample;
        return result;
    });
    assert.deepEqual(counts, { first: 301, all: 300, some: 30, none: 0, file: 0, turned: 0, apart: counts.apart });
    assert.ok(counts.apart < 1e-3, `light depends on the place alone: ${counts.apart}`);
});

test('life: lights of a clone are those of the file in each mode, and dispose() takes back what it changed', async () => {
    const { page, call } = await studio.pageOf('three');
    await call('load', { file: '/assets/conformance/five_lights.glb' });
    const result = await page.evaluate(async () => {
        const { loaded, makeRenderer, viewOf } = window.halflightPage;
        const r = await makeRenderer(32, 18);
        const { halflight, scene, gltf } = loaded;
        const view = viewOf('main', 16 / 9);
        const lightsOf = (root) => {
            const lights = [];
            root.traverse((o) => o.isLight && lights.push(`${o.name} ${o.layers.mask} ${o.castShadow} ${o.shadow?.mapSize.x}`));
            return lights;
        };
        const loadedLights = lightsOf(gltf.scene);
        halflight.mode = 'shadowmask'; // the fifth light is in the lightmap alone
        halflight.update(r, view);
        const copy = gltf.scene.clone();
        scene.add(copy);
        const pairs = ['shadowmask', 'realtime'].map((mode) => {
            halflight.mode = mode;
            halflight.update(r, view);
            return [lightsOf(gltf.scene), lightsOf(copy)];
        });
        halflight.dispose();
        loaded.halflight = null;
        return { pairs, loadedLights, after: [lightsOf(gltf.scene), lightsOf(copy)] };
    });
    const [masks, realtime] = result.pairs;
    assert.notDeepEqual(masks[0], realtime[0], 'a light is switched');
    for (const [own, copied] of result.pairs) assert.deepEqual(copied, own);
    for (const lights of result.after) assert.deepEqual(lights, result.loadedLights);
});
