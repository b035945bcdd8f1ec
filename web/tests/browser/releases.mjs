// Every release of three.js that the plug-in takes draws what the newest draws.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { studio } from './studio.mjs';

const SIZE = [240, 135];
const MODES = ['shadowmask', 'distance-shadowmask', 'realtime'];

for (const renderer of ['webgl', 'webgpu']) {
    test(`releases of three.js: the courtyard, ${renderer}`, async () => {
        studio.bake('courtyard', 'courtyard', '--lightmap-size', '256');
        const pictures = new Map();
        const { camera } = studio.reference('courtyard', 'shadowmask');
        for (const release of ['', '-0.186', '-0.185', '-0.184', '-0.183']) {
            const { call } = await studio.pageOf(`three${release}`, renderer);
            await studio.load(call, 'courtyard');
            for (const mode of MODES) {
                await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { mode, debugView: 'lit', shadowDistance: 60, shadowFadeRange: 1 } });
                if (!pictures.has(mode)) pictures.set(mode, await call('picture'));
                const { mean, within } = await call('agreement', { other: pictures.get(mode) });
                console.log(`three${release}, ${mode}, ${renderer}: ${mean.toFixed(4)} of 255 from the newest, ${(100 * within).toFixed(2)} % of pixels within 1`);
                assert.ok(mean <= 0.1, `three${release}, ${mode}: ${mean} of 255`);
            }
        }
    });
}
