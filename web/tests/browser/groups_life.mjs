// Light groups (spec S33) at run time: what sets a weight, what follows it, what a frame without a change does, and animations.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { bakeGroups, compose, STATES } from './groups_scene.mjs';
import { SIZE, studio } from './studio.mjs';

const near = (a, b, most = 1e-4) => a.every((x, i) => Math.abs(x - b[i]) <= most * Math.max(1, Math.abs(b[i])));

/** The page with the file as it was loaded, and a frame function in it. */
async function open(renderer = 'webgl', name = bakeGroups()) {
    const { page, call } = await studio.pageOf('three', renderer);
    await call('load', { file: `/files/${name}.glb` });
    await page.evaluate(async () => {
        const { loaded, makeRenderer, viewOf } = window.halflightPage;
        const r = await makeRenderer(64, 36);
        const { halflight } = loaded;
        halflight.mode = 'shadowmask';
        const view = viewOf('main', 16 / 9);
        window.groupsPage = {
            halflight, r, view,
            frame: () => { halflight.update(r, view); return [...halflight.warnings]; },
            weight: (group) => halflight.lightGroups.find(({ name }) => name === group).weight,
            light: (name) => halflight.lights.find((state) => state.name === name).light,
        };
        window.groupsPage.frame();
    });
    return { page, call };
}

test('groups S33: the list of groups, and setters that refuse what is no weight', async () => {
    const { page } = await open();
    const { list, refused, kept } = await page.evaluate(async () => {
        const { halflight } = window.groupsPage;
        const { THREE } = window.halflightPage;
        const list = halflight.lightGroups;
        const refused = [['attic', 1], ['lamp', NaN], ['lamp', -1], ['lamp', 2e12], ['lamp', '1'], ['lamp', [1, 2]], ['lamp', [1, 2, -3]], ['lamp', null], ['lamp', undefined]].map(([name, value]) => {
            try {
                halflight.setLightGroup(name, value);
                return `${name} = ${value} was taken`;
            } catch (error) {
                return error.message;
            }
        });
        const kept = [window.groupsPage.weight('lamp')];
        for (const value of [0.5, [1, 2, 3], new THREE.Color().setRGB(0.1, 0.2, 0.3)]) {
            halflight.setLightGroup('lamp', value);
            kept.push(window.groupsPage.weight('lamp'));
        }
        return { list, refused, kept };
    });
    assert.deepEqual(list.map(({ name }) => name).sort(), ['day', 'east', 'lamp', 'sun', 'west']);
    for (const { weight, savedWeight } of list) assert.deepEqual(weight, savedWeight);
    assert.match(refused[0], /^there is no light group "attic": the file has .*lamp/);
    for (const sentence of refused.slice(1)) assert.match(sentence, /^the weight of light group "lamp" is .*: it is a/, sentence);
    assert.ok(near(kept[0], [1, 0.1, 0.05]) && near(kept[1], [0.5, 0.5, 0.5]) && near(kept[2], [1, 2, 3]) && near(kept[3], [0.1, 0.2, 0.3]), JSON.stringify(kept));
});

for (const renderer of ['webgl', 'webgpu']) {
    test(`groups S33: frames without a change do nothing, ${renderer}`, async () => {
        const { page } = await open(renderer);
        const counts = await page.evaluate(() => {
            const { halflight, frame } = window.groupsPage;
            const { draws } = halflight.backend.composer;
            const { draw } = draws;
            const { mix } = halflight.field;
            const count = { draws: 0, mixes: 0, versions: halflight.table.texture.version };
            draws.draw = function (...all) { count.draws += 1; return draw.apply(this, all); };
            halflight.field.mix = function (...all) { count.mixes += 1; return mix.apply(this, all); };
            const after = (change) => {
                Object.assign(count, { draws: 0, mixes: 0 });
                const { version } = halflight.reflections.texture;
                change();
                frame();
                return { ...count, pictures: halflight.reflections.texture.version - version, isFollowing: halflight.isFollowing };
            };
            const result = [() => {}, () => {}, () => halflight.setLightGroup('lamp', halflight.lightGroups.find(({ name }) => name === 'lamp').weight), () => halflight.setLightGroup('lamp', 0.3), () => {}, () => {}, () => {}].map(after);
            draws.draw = draw;
            halflight.field.mix = mix;
            return result;
        });
        const drawn = counts.map(({ draws }) => draws);
        assert.deepEqual(drawn, [0, 0, 0, 1, 0, 0, 0]);
        // The picture of reflection probes has 44,032 texels in maps; 16,384 are added up a frame.
        assert.deepEqual(counts.map(({ isFollowing }) => isFollowing), [false, false, false, true, true, false, false]);
        assert.deepEqual(counts.map(({ pictures }) => pictures), [0, 0, 0, 0, 0, 1, 0], 'uploads of that picture');
        const mixes = counts.map(({ mixes: n }) => n);
        assert.deepEqual([...mixes.slice(0, 3), ...mixes.slice(5)], [0, 0, 0, 0, 0]);
        // Two objects, and a volume of 18^3 texels in two frames.
        assert.deepEqual([mixes[3], mixes[4]], [4096 + 2, 18 ** 3 - 4096], 'a volume is lit anew piece by piece');
    });
}

test('groups S33: volumes that were lit anew are those of a file with that light', async () => {
    const label = 'a bright evening';
    const { page } = await open();
    const texels = () => page.evaluate(async (state) => {
        const { halflight, frame } = window.groupsPage;
        for (const [name, rgb] of Object.entries(halflight.lightGroups.length > 0 ? state : {})) halflight.setLightGroup(name, rgb);
        for (let i = 0; i < 3; ++i) frame();
        const { volumes } = halflight;
        const [v] = volumes.volumes;
        const { DataUtils } = window.halflightPage.THREE;
        const factor = halflight.table.texture.image.data[halflight.table.at(v.row, 4) + 3];
        return Array.from(volumes.texture.image.data, (x, i) => DataUtils.fromHalfFloat(x) * (Math.floor(i / 4 / (volumes.size[0] * volumes.size[1] * volumes.size[2])) === 3 ? 1 : factor));
    }, STATES[label]);
    const ours = await texels();
    await open('webgl', compose(bakeGroups(), label));
    const theirs = await texels();
    const most = theirs.reduce((largest, x) => Math.max(largest, Math.abs(x)), 0);
    const apart = ours.reduce((worst, x, i) => Math.max(worst, Math.abs(x - theirs[i])), 0);
    assert.ok(ours.length === theirs.length && most > 0 && apart <= 2e-3 * most, `${apart} of ${most}`);
});

test('groups S33: lights set the weight of their group, and follow it', async () => {
    const { page } = await open();
    const result = await page.evaluate(() => {
        const { frame, halflight, light, weight } = window.groupsPage;
        const all = {};
        const rgb = ({ color, intensity }) => [color.r, color.g, color.b].map((x) => x * intensity);
        halflight.setLightGroup('lamp', [0.5, 1, 2]);
        all.mixed = rgb(light('lamp'));
        halflight.setLightGroup('sun', [0, 2, 0]);
        all.baked = rgb(light('sun'));
        light('lamp').intensity *= 3;
        frame();
        all.brighter = weight('lamp');
        light('sun').color.setRGB(1, 1, 1); // 80 lux since its weight of 2
        frame();
        all.whiteSun = weight('sun');
        light('lamp').visible = false;
        frame();
        all.hidden = [weight('lamp'), halflight.backend.composer.versions.get(halflight.backend.composer.draws.deviceOf(window.groupsPage.r)) === halflight.groups.version];
        halflight.setLightGroup('lamp', 1); // what it has when it is shown again
        all.hiddenStill = weight('lamp');
        light('lamp').visible = true;
        frame();
        all.shown = weight('lamp');
        const { THREE, loaded } = window.halflightPage;
        const node = new THREE.Group().add(light('sun'));
        loaded.gltf.scene.add(node);
        node.visible = false;
        frame();
        all.below = weight('sun');
        node.visible = true;
        all.sentences = frame();
        const strip = loaded.gltf.scene.getObjectByName('strip_west');
        halflight.setLightGroup('west', [2, 0, 1]);
        const { emissive, emissiveIntensity } = strip.material;
        all.emission = [emissive.r, emissive.g, emissive.b].map((x) => x * emissiveIntensity);
        halflight.dispose();
        all.restored = [rgb(light('lamp')), rgb(light('sun')), [emissive.r, emissive.g, emissive.b].map((x) => x * strip.material.emissiveIntensity)];
        loaded.halflight = null;
        return all;
    });
    assert.ok(near(result.mixed, [3, 6, 12]), `white of 6 cd: ${result.mixed}`);
    assert.ok(near(result.baked, [0, 80, 0]), `white of 40 lux: ${result.baked}`);
    assert.ok(near(result.brighter, [1.5, 3, 6]), `${result.brighter}`);
    assert.ok(near(result.whiteSun, [2, 2, 2]), `${result.whiteSun}`);
    assert.deepEqual(result.hidden, [[0, 0, 0], true]);
    assert.deepEqual(result.hiddenStill, [0, 0, 0]);
    assert.ok(near(result.shown, [1, 1, 1]), `${result.shown}`);
    assert.deepEqual(result.below, [0, 0, 0]);
    assert.deepEqual(result.sentences, [], 'all follows');
    assert.ok(near(result.emission, [60, 0, 30]), `white of 30 cd/m2: ${result.emission}`);
    assert.ok(near(result.restored[0], [6, 0.6, 0.3]) && near(result.restored[1], [40, 38, 34]) && near(result.restored[2], [30, 21.9, 14.1], 1e-3), JSON.stringify(result.restored));
});

test('groups S33: a light that leaves its group has a sentence', async () => {
    const name = 'one-group';
    const file = readGlb(studio.pathOf(bakeGroups()));
    for (const node of file.json.nodes) if (node.extensions?.HALFLIGHT_light?.baking?.group !== undefined) node.extensions.HALFLIGHT_light.baking.group = 0;
    writeGlb(studio.pathOf(name), file);
    const { page } = await open('webgl', name);
    const result = await page.evaluate(() => {
        const { frame, halflight } = window.groupsPage;
        const [group] = halflight.lightGroups;
        const members = halflight.lights.filter(({ data }) => data.group === 0).map(({ light }) => light);
        for (const light of members) light.intensity = 10; // of both, by two factors
        const apart = [frame(), halflight.lightGroups[0].weight];
        halflight.setLightGroup(group.name, group.savedWeight);
        const back = frame();
        for (const light of members) light.intensity *= 2;
        return { apart, back, saved: group.savedWeight, together: [frame(), halflight.lightGroups[0].weight] };
    });
    assert.ok(result.apart[0].length > 0 && result.apart[0].every((s) => /changed by itself: its baked light is that of all of light group/.test(s)), result.apart[0].join());
    assert.deepEqual(result.apart[1], result.saved);
    assert.deepEqual(result.back, []);
    assert.ok(near(result.together[1], result.saved.map((x) => 2 * x)), `${result.together[1]}`);
    assert.deepEqual(result.together[0], []);
});

test('groups S33: a light that the file hides has the weight 0', async () => {
    const name = 'hidden-lamp';
    const file = readGlb(studio.pathOf(bakeGroups()));
    file.json.nodes.find((node) => node.name === 'lamp').extensions.KHR_node_visibility = { visible: false };
    writeGlb(studio.pathOf(name), file);
    const { page } = await open('webgl', name);
    const { weight, visible, saved } = await page.evaluate(() => {
        const { halflight, light } = window.groupsPage;
        const { weight, savedWeight: saved } = halflight.lightGroups.find((group) => group.name === 'lamp');
        return { weight, saved, visible: light('lamp').visible };
    });
    assert.equal(visible, false);
    assert.ok(near(saved, [1, 0.1, 0.05]), `${saved}`);
    assert.deepEqual(weight, [0, 0, 0]);
});

/** The baked file with an animation: values of three numbers at 0 and 1 seconds by pointer. */
function animated(name, channels) {
    const { json, buffer } = readGlb(studio.pathOf(bakeGroups()));
    const parts = [buffer];
    const add = (numbers, type, componentType = 5126) => {
        const bytes = componentType === 5126 ? Buffer.from(Float32Array.from(numbers).buffer) : Buffer.from(Uint8Array.from(numbers));
        const padded = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4)]);
        const byteOffset = parts.reduce((sum, part) => sum + part.length, 0);
        parts.push(padded);
        const bufferView = json.bufferViews.push({ buffer: 0, byteOffset, byteLength: bytes.length }) - 1;
        const size = { SCALAR: 1, VEC3: 3 }[type];
        return json.accessors.push({ bufferView, componentType, count: numbers.length / size, type, ...(componentType === 5126 && type === 'SCALAR' ? { min: [Math.min(...numbers)], max: [Math.max(...numbers)] } : {}) }) - 1;
    };
    const input = add([0, 1], 'SCALAR');
    const samplers = channels.map(({ values, type, interpolation = 'LINEAR', componentType }) => ({ input, output: add(values, type, componentType), interpolation }));
    json.animations = [{ name: 'evening', samplers, channels: channels.map(({ pointer }, sampler) => ({ sampler, target: { path: 'pointer', extensions: { KHR_animation_pointer: { pointer } } } })) }];
    json.extensionsUsed = [...json.extensionsUsed, 'KHR_animation_pointer'];
    json.buffers[0].byteLength = parts.reduce((sum, part) => sum + part.length, 0);
    writeGlb(studio.pathOf(name), { json, buffer: Buffer.concat(parts) });
    return json;
}

test('groups S33: KHR_animation_pointer plays weights, lights and visibility', async () => {
    const names = readGlb(studio.pathOf(bakeGroups())).json.extensions.HALFLIGHT_mixed_lighting.groups.map(({ name }) => name);
    const pointer = (name) => `/extensions/HALFLIGHT_mixed_lighting/groups/${names.indexOf(name)}/weight`;
    const nodes = readGlb(studio.pathOf(bakeGroups())).json.nodes;
    const sun = nodes.findIndex(({ name }) => name === 'sun');
    animated('animated', [
        { pointer: pointer('west'), type: 'VEC3', values: [0, 0, 0, 1, 2, 3] },
        { pointer: pointer('east'), type: 'VEC3', values: [0, 1, 0, 1, 0, 1], interpolation: 'STEP' },
        { pointer: pointer('day'), type: 'VEC3', values: [0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 2, 2, 2, 0, 0, 0], interpolation: 'CUBICSPLINE' },
        { pointer: '/extensions/KHR_lights_punctual/lights/0/intensity', type: 'SCALAR', values: [6, 12] },
        { pointer: `/nodes/${sun}/extensions/KHR_node_visibility/visible`, type: 'SCALAR', values: [1, 0], interpolation: 'STEP', componentType: 5121 },
        { pointer: '/extensions/HALFLIGHT_mixed_lighting/groups/9/weight', type: 'VEC3', values: [0, 0, 0, 1, 1, 1] },
    ]);
    const { page } = await open('webgl', 'animated');
    const result = await page.evaluate(() => {
        const { THREE, loaded } = window.halflightPage;
        const { frame, halflight, weight } = window.groupsPage;
        const [clip] = loaded.gltf.animations;
        const said = [];
        const { warn } = console;
        console.warn = (...words) => said.push(words.join(' '));
        const play = (root) => {
            const mixer = new THREE.AnimationMixer(root);
            const action = mixer.clipAction(clip).play();
            action.loop = THREE.LoopOnce;
            action.clampWhenFinished = true;
            return mixer;
        };
        const state = () => { frame(); return Object.fromEntries(['west', 'east', 'day', 'lamp', 'sun'].map((name) => [name, weight(name)])); };
        const mixer = play(loaded.gltf.scene);
        mixer.setTime(0.5);
        const half = state();
        mixer.setTime(1);
        const end = state();
        mixer.stopAllAction();
        const copy = loaded.gltf.scene.clone();
        loaded.scene.add(copy);
        play(copy).setTime(0.25);
        frame();
        console.warn = warn;
        return { duration: clip.duration, tracks: clip.tracks.length, half, end, ofClone: weight('west'), said, warnings: [...halflight.warnings] };
    });
    assert.equal(result.duration, 1);
    assert.equal(result.tracks, 5);
    assert.ok(near(result.half.west, [0.5, 1, 1.5]) && near(result.half.east, [0, 1, 0]) && near(result.half.day, [1.5, 1.5, 1.5]) && near(result.half.lamp, [1.5, 0.15, 0.075]), JSON.stringify(result.half));
    assert.ok(near(result.half.sun, [1, 0.95, 0.85]) && near(result.end.sun, [0, 0, 0]), 'a light that is hidden has the weight 0');
    assert.ok(near(result.end.west, [1, 2, 3]) && near(result.end.east, [1, 0, 1]) && near(result.end.day, [2, 2, 2]) && near(result.end.lamp, [2, 0.2, 0.1]), JSON.stringify(result.end));
    assert.ok(near(result.ofClone, [0.25, 0.5, 0.75]), `an animation of a clone: ${result.ofClone}`);
    assert.deepEqual(result.said.filter((text) => /PropertyBinding|No target/.test(text)), []);
    assert.ok(result.warnings.some((s) => s.startsWith('animation "evening" does not play /extensions/HALFLIGHT_mixed_lighting/groups/9/weight')), result.warnings.join(' | '));
});

test('groups S33: a lost context, and a second renderer, have the light too', async () => {
    const { page, call } = await open();
    const { camera } = studio.reference(bakeGroups(), 'shadowmask', []);
    await page.evaluate(() => {
        const { halflight, frame } = window.groupsPage;
        halflight.setLightGroup('lamp', [0, 2, 0]);
        for (let i = 0; i < 3; ++i) frame(); // until the volume has it
    });
    const draw = () => call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask' } });
    await draw();
    const other = await call('picture');
    await page.evaluate(async () => {
        const { r } = window.groupsPage;
        const canvas = r.domElement;
        const restored = new Promise((resolve) => canvas.addEventListener('webglcontextrestored', resolve, { once: true }));
        r.forceContextLoss();
        await new Promise((resolve) => setTimeout(resolve, 100));
        r.forceContextRestore();
        await restored;
    });
    await draw();
    const result = await call('agreement', { other });
    assert.ok(result.mean <= 0.01, `after a lost context: ${JSON.stringify(result)}`);
    await page.evaluate(async () => {
        const { THREE, loaded } = window.halflightPage;
        const first = loaded.renderer;
        const second = new THREE.WebGLRenderer({ antialias: false });
        second.shadowMap.enabled = true;
        second.shadowMap.type = THREE.PCFShadowMap;
        loaded.renderer = second;
        window.firstRenderer = first;
    });
    await draw();
    const again = await call('agreement', { other });
    await page.evaluate(() => {
        const { loaded } = window.halflightPage;
        loaded.renderer.dispose();
        loaded.renderer = window.firstRenderer;
    });
    assert.ok(again.mean <= 0.01, `by a second renderer: ${JSON.stringify(again)}`);
});

for (const renderer of ['webgl', 'webgpu']) {
    test(`groups S33: dispose() frees the pages of groups, ${renderer}`, async () => {
        const { page } = await open(renderer);
        const memory = await page.evaluate(async (file) => {
            const { loaded, load } = window.halflightPage;
            const counts = [];
            for (let i = 0; i < 4; ++i) {
                await load({ file });
                const { halflight, scene } = loaded;
                const { r, view } = window.groupsPage;
                halflight.update(r, view);
                r.render(scene, view);
                const during = r.info.memory.textures;
                halflight.dispose();
                scene.traverse((o) => o.isLight && o.dispose());
                counts.push([during, r.info.memory.textures]);
            }
            loaded.halflight = null;
            return counts;
        }, `/files/${bakeGroups()}.glb`);
        assert.ok(memory[0][0] >= memory[0][1] + 12, `sources of six parts: ${JSON.stringify(memory)}`);
        assert.equal(memory[3][1], memory[1][1], JSON.stringify(memory));
    });
}
