// Texture units: with 16, shadow maps of all lights of all files in a scene fit, and those that matter least go.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { studio } from './studio.mjs';

const FILE = '/assets/conformance/five_lights.glb';

/** Files and lights of the application in one scene. Runs in the page; returns what each step shows. */
async function measure({ file, files, suns }) {
    const { loaded, load, makeRenderer, viewOf, THREE, GLTFLoader, HalflightPlugin } = window.halflightPage;
    const r = await makeRenderer(64, 36);
    const gl = r.isWebGLRenderer ? r.getContext() : null;
    const before = r.capabilities?.maxTextures;
    const { type } = r.shadowMap;
    r.shadowMap.type = THREE.BasicShadowMap; // compiles sooner
    if (gl) r.capabilities.maxTextures = 16; // WebGPU has 16
    const faults = [];
    r.backend?.device?.addEventListener('uncapturederror', ({ error }) => faults.push(error.message));
    await load({ file });
    const { scene } = loaded;
    const all = [loaded.halflight];
    const loader = new GLTFLoader();
    loader.register((parser) => new HalflightPlugin(parser));
    for (let i = 1; i < files; ++i) {
        const other = await loader.loadAsync(file);
        all.push(other.userData.halflight);
        other.scene.position.x = 7 * i;
        scene.add(other.scene);
    }
    for (let i = 0; i < suns; ++i) {
        const sun = new THREE.DirectionalLight(0xffffff, 0.1);
        sun.castShadow = true;
        scene.add(sun, sun.target);
    }
    const camera = viewOf('main', 16 / 9);
    const known = new Set(r.info.programs ?? []);
    const states = all.flatMap((halflight) => halflight.lights).filter((state) => state.data.channel >= 0); // the others are in the lightmap
    for (const state of states) state.light.shadow.mapSize.setScalar(32);
    const frame = (draw = false) => {
        for (const halflight of all) halflight.update(r, camera);
        if (draw) r.render(scene, camera);
        const said = all.flatMap((halflight) => [...halflight.warnings]).filter((sentence) => sentence.includes('gets no realtime shadow'));
        return { cast: states.map(({ light }) => light.castShadow), said };
    };
    const importance = () => states.map((state) => {
        const { r: red, g, b } = state.light.color;
        const distance = new THREE.Vector3().setFromMatrixPosition(state.light.matrixWorld).distanceTo(camera.position);
        return ((0.2126 * red + 0.7152 * g + 0.0722 * b) * state.light.intensity) / Math.max(distance, 1) ** 2;
    });
    for (const halflight of all) halflight.mode = 'distance-shadowmask';
    const result = { names: states.map((state) => state.name), frames: [] };
    if (!gl) all[0].update(new THREE.WebGPURenderer(), camera); // before its init()
    result.first = frame(true);
    result.importance = importance();
    for (let i = 0; i < 4; ++i) {
        camera.position.x += i % 2 ? 0.002 : -0.002;
        result.frames.push(frame());
    }
    // All equal at the camera: had maps all, the first by name keep theirs.
    const powers = importance();
    states.forEach((state, i) => { state.light.intensity *= 1e-3 / powers[i]; });
    for (const state of states) state.mapAllowed = true;
    result.equal = frame();
    const programs = gl ? r.info.programs.filter((program) => !known.has(program)).map(({ program }) => program) : [];
    const samplers = new Set([gl?.SAMPLER_2D, gl?.SAMPLER_3D, gl?.SAMPLER_CUBE, gl?.SAMPLER_2D_ARRAY, gl?.SAMPLER_2D_SHADOW, gl?.SAMPLER_CUBE_SHADOW]);
    result.samplers = programs.map((program) => {
        let count = 0;
        for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
            const { type, size } = gl.getActiveUniform(program, i);
            if (samplers.has(type)) count += size;
        }
        return count;
    });
    await r.backend?.device?.queue.onSubmittedWorkDone();
    if (gl) r.capabilities.maxTextures = 32;
    result.more = gl ? frame().said : [];
    if (gl) r.capabilities.maxTextures = before;
    r.shadowMap.type = type;
    all.slice(1).forEach((halflight) => halflight.dispose());
    return { ...result, faults };
}

// The plug-in takes four units, three.js's table one of them.
for (const [renderer, files, suns] of [['webgl', 2, 6], ['webgpu', 1, 9]]) {
    test(`units: shadow maps of all lights and files fit 16 units, ${renderer}`, async () => {
        const { page } = await studio.pageOf('three', renderer);
        const errors = [];
        const listen = (message) => message.type() === 'error' && errors.push(message.text());
        page.on('console', listen);
        const { names, importance, first, frames, equal, samplers, more, faults } = await page.evaluate(measure, { file: FILE, files, suns });
        page.off('console', listen);
        assert.deepEqual([...errors, ...faults], []);
        const count = first.cast.filter(Boolean).length;
        assert.equal(count, 16 - 4 - suns, 'each unit that is left has a shadow map');
        assert.equal(first.said.length, 4 * files - count, 'a sentence for each of the others');
        const of = (cast) => importance.filter((_, i) => first.cast[i] === cast);
        assert.ok(Math.min(...of(true)) >= Math.max(...of(false)), 'the largest at the camera');
        for (const { cast } of frames) assert.deepEqual(cast, first.cast, 'the same while the camera trembles');
        const sorted = [...names].sort();
        assert.deepEqual(names.filter((_, i) => equal.cast[i]).sort(), sorted.slice(0, count), 'of equal ones the first by name');
        if (renderer !== 'webgl') return;
        assert.deepEqual(more, [], 'with more units all have theirs');
        console.log(`texture units of the programs: ${samplers.join()}`);
        assert.ok(Math.max(...samplers) === 16, `${samplers}`);
    });
}
