// Every release of three.js that the plug-in takes draws what the newest draws. Each renderer is a part, as both take long.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { web } from './harness.mjs';
import { bakeGroups, setGroups, STATES } from './browser/groups_scene.mjs';
import { studio } from './browser/studio.mjs';

const SIZE = [240, 135];
const RELEASES = ['three', 'three-0.186', 'three-0.185', 'three-0.184', 'three-0.183'];
const absent = RELEASES.filter((name) => !existsSync(join(web, 'node_modules', name)));
const MODES = ['shadowmask', 'realtime'];

/** @param {string} renderer of three.js */
export function compareReleases(renderer) {
    test(`releases of three.js: the courtyard, ${renderer}`, { skip: absent.length > 0 ? `no ${absent.join()}: run npm install in web/` : false }, async () => {
        studio.bake('courtyard', 'courtyard', '--lightmap-size', '256');
        const pictures = new Map();
        const { camera } = studio.reference('courtyard', 'shadowmask');
        for (const release of RELEASES) {
            const { call } = await studio.pageOf(release, renderer);
            await studio.load(call, 'courtyard');
            for (const mode of MODES) {
                await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode, debugView: 'lit', shadowDistance: 60, shadowFadeRange: 1 } });
                if (!pictures.has(mode)) pictures.set(mode, await call('picture'));
                const { mean, within } = await call('agreement', { other: pictures.get(mode) });
                console.log(`${release}, ${mode}, ${renderer}: ${mean.toFixed(4)} of 255 from the newest, ${(100 * within).toFixed(2)} % of pixels within 1`);
                assert.ok(mean <= 0.1, `${release}, ${mode}: ${mean} of 255`);
            }
        }
    });
    for (const own of renderer === 'webgpu' ? ['webgpu', 'webgl2-nodes'] : [renderer])
        test(`releases of three.js: light groups S33, ${own}`, { skip: absent.length > 0 ? `no ${absent.join()}: run npm install in web/` : false }, async () => {
            for (const name of [false, true].map((onePage) => bakeGroups({ onePage, plain: true }))) {
                const { camera } = studio.reference(name, 'shadowmask');
                let other = null;
                for (const release of RELEASES) {
                    const { page, call } = await studio.pageOf(release, own);
                    await studio.load(call, name);
                    await setGroups(page, STATES['a bright evening']);
                    await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode: 'shadowmask', debugView: 'lit', shadowDistance: 60, shadowFadeRange: 1 } });
                    other ??= await call('picture');
                    const { mean } = await call('agreement', { other });
                    console.log(`${release}, ${name}, ${own}: ${mean.toFixed(4)} of 255 from the newest`);
                    assert.ok(mean <= 0.1, `${release}, ${name}: ${mean} of 255`);
                    await setGroups(page, {});
                }
            }
        });
}
