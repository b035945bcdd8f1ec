// Reflection probes on metal in two rooms: without them the picture differs by 9 of 255.
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb, writeGlb } from '../glb.mjs';
import { halflight, repository } from '../harness.mjs';
import { studio } from './studio.mjs';

for (const renderer of ['webgl', 'webgpu']) {
    test(`reflection probes, ${renderer}`, async () => {
        const name = 'metal-rooms';
        if (!studio.baked.has(name)) {
            const file = readGlb(join(repository, 'assets/tests/two_rooms.glb'));
            for (const material of file.json.materials) material.pbrMetallicRoughness = { ...material.pbrMetallicRoughness, metallicFactor: 1, roughnessFactor: 0.3 };
            const source = studio.pathOf('metal-rooms-source');
            writeGlb(source, file);
            halflight('bake', source, '-o', studio.pathOf(name), '--quality', 'preview', '-q');
            studio.baked.add(name);
        }
        const { call } = await studio.pageOf('three', renderer);
        await studio.load(call, name);
        await studio.compare(call, `reflection probes, ${renderer}`, 'shadowmask', { name });
    });
}
