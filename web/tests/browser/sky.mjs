// A sky's picture by both renderers against the program's: behind the scene, and in realtime mode as ambient and in mirrors.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { studio } from './studio.mjs';

/** A Radiance picture of 64 x 32 texels: a colour for each quarter of a turn, darker below, and a sun. */
export function writeSky(path) {
    const texel = (x, y) => {
        if (x >= 40 && x < 42 && y >= 8 && y < 10) return [255, 240, 200, 128 + 6];
        const color = [[200, 90, 80], [80, 180, 90], [90, 110, 210], [190, 170, 60]][x >> 4];
        return [...color, y < 16 ? 128 : 126];
    };
    const bytes = Array.from({ length: 64 * 32 }, (_, i) => texel(i % 64, Math.floor(i / 64))).flat();
    writeFileSync(path, Buffer.concat([Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n'), Buffer.from(bytes)]));
}

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
