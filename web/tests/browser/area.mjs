// Area lights, rectangle and disk, by both renderers against the program's: masks, gloss and range.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { studio } from './studio.mjs';

// All is static, so that in shadowmask mode no shadow map is drawn, which three.js has none of for area lights.
const SETTINGS = `
[[node]]
pattern = "*"
static = true
[[light]]
pattern = "*"
intensity = 0
[[add_light]]
type = "rectangle"
name = "window"
size = [1.5, 1]
position = [-2, 2.2, 1]
direction = [1, -1, -0.3]
intensity = 2
color = [0.6, 0.8, 1]
[[add_light]]
type = "disk"
name = "lamp"
size = 0.8
position = [1.5, 2.5, 0.5]
direction = [-0.4, -1, 0]
intensity = 4
range = 9
color = [1, 0.7, 0.4]
`;

for (const renderer of ['webgl', 'webgpu']) {
    test(`area lights, ${renderer}`, async () => {
        const settings = join(studio.files, 'area.toml');
        writeFileSync(settings, SETTINGS);
        studio.bake('tests/sphere_on_floor', 'area-lights', '--settings', settings);
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'area-lights');
        assert.ok((await call('lightNames')).includes('window'));
        const { warnings } = await studio.compare(call, `area lights, ${renderer}`, 'shadowmask', { name: 'area-lights' });
        assert.deepEqual(warnings.filter((sentence) => sentence.includes('area light')), []);
        // Every object casts into the map of the program then; the plug-in says that it has none.
        const realtime = await call('draw', { width: 64, height: 36, camera: 'main', settings: { mode: 'realtime' } });
        assert.ok(realtime.warnings.some((sentence) => sentence.startsWith('area light "window" has no realtime shadow')));
    });
}
