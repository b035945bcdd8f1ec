// A sky's picture by both renderers against the program's: behind the scene, and in realtime mode as ambient and in mirrors.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { writeSky } from '../pictures.mjs';
import { studio } from './studio.mjs';

for (const renderer of ['webgl', 'webgpu']) {
    test(`sky picture, ${renderer}`, async () => {
        writeSky(join(studio.files, 'sky.hdr'));
        const settings = join(studio.files, 'sky.toml');
        writeFileSync(settings, '[sky]\nimage = "sky.hdr"\nrotation = 25\nintensity = 2\n');
        studio.bake('tests/sphere_on_floor', 'sky-picture', '--settings', settings);
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, 'sky-picture');
        for (const mode of ['shadowmask', 'realtime']) await studio.compare(call, `sky picture, ${renderer}`, mode, { name: 'sky-picture' });
    });
}
