// The conformance pack (docs/conformance.md): each of its pictures by a renderer.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { repository } from '../harness.mjs';
import { setGroups } from './groups_scene.mjs';
import { studio } from './studio.mjs';

const pack = JSON.parse(readFileSync(join(repository, 'assets/conformance/pictures.json'), 'utf8'));
/** In the pack's small pictures the mipmap level of its normal map decides: drivers round it in different ways. */
const LARGER = new Set(['bumpy_wall.glb']);
/** Pixels of even surfaces that a picture shows at least: in lit rooms fewer are even, and of metal fewer still. */
const LEAST_EVEN = { 'light_groups.glb': 200, 'metal_rooms.glb': 50 };

function checkPack(label, result, leastEven = 1000) {
    const { meanRelative, shareOfPixels } = pack.tolerances;
    assert.ok(result.meanRelative <= meanRelative, `${label}: luminance differs by ${result.meanRelative} of its mean`);
    assert.ok(result.share >= shareOfPixels, `${label}: ${result.share} of the pixels are right`);
    assert.ok(result.evenPixels >= leastEven && result.even >= 0.995, `${label}: of ${result.evenPixels} pixels of even surfaces ${result.even} are within 1 %`);
}

/** Tests of all files of the pack. @param {'webgl' | 'webgpu'} renderer */
export function testPack(renderer) {
    for (const { file, purpose } of pack.files) {
        test(`conformance, ${renderer}, ${file}: ${purpose}`, async () => {
            const { page, call } = await studio.pageOf('three', renderer);
            const name = `conformance/${file.replace('.glb', '')}`;
            const { cellsOfFile } = await studio.load(call, name);
            assert.ok(cellsOfFile, 'probes are interpolated in the tetrahedra that the file holds');
            for (const { mode, camera, groups = {}, shadowDistance, shadowFadeRange, picture } of pack.pictures.filter((p) => p.file === file)) {
                const label = `${file} ${camera}, ${renderer}`;
                await setGroups(page, groups);
                const settings = { shadowDistance, shadowFadeRange };
                if (LARGER.has(file)) {
                    await studio.compare(call, label, mode, { name, settings });
                    continue;
                }
                const reference = `/assets/conformance/${picture}`;
                checkPack(label, await studio.compareWith(call, `${label}, ${mode}`, { reference, camera, size: pack.size, settings: { debugView: 'lit', mode, ...settings } }), LEAST_EVEN[file]);
            }
        });
    }
}
