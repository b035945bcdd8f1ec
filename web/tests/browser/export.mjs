// Exported core glTF in three.js without any plug-in, in a real browser, against pictures of the program.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { halflight, repository, serve } from '../harness.mjs';
import { SIZE, studio } from './studio.mjs';

const look = process.env.HALFLIGHT_WEB_PICTURES;

async function plainPage(url) {
    const page = await studio.newPage();
    await page.goto(`${url}/web/tests/page/plain.html`);
    await page.waitForFunction('window.ready === true');
    return page;
}

/** Exports a scene in a style and returns the report. */
function exportScene(scene, name, style) {
    const source = join(repository, 'assets', `${scene}.glb`);
    const output = join(studio.files, `${name}.glb`);
    return JSON.parse(halflight('bake', source, '-o', output, '--quality', 'preview', '--export', style, '--json')).export;
}

// The limits are about twice what was measured: textures are seen through the pictures' texels.
for (const { scene, limit } of [{ scene: 'tests/bumpy_wall', limit: 1.5 }, { scene: 'tests/four_lights', limit: 1.5 }]) {
    test(`${scene}, unlit and emissive`, async () => {
        const label = `${scene.split('/').pop()}-all-baked`;
        const settings = join(studio.files, 'all-baked.toml');
        writeFileSync(settings, '[[light]]\npattern = "*"\nmode = "baked"\n');
        studio.bake(scene, label, '--mode', 'baked-indirect', '--settings', settings);
        const { url: reference, camera } = studio.reference(label, 'baked-indirect', ['--specular', 'off']);
        const server = await serve(studio.files);
        const page = await plainPage(server.url);
        for (const [style, type] of [['unlit', 'MeshBasicMaterial'], ['emissive', 'MeshPhysicalMaterial']]) {
            const name = `${label}-${style}`;
            const report = exportScene(scene, name, style);
            assert.ok(!readFileSync(join(studio.files, `${name}.glb`)).includes('HALFLIGHT_'));
            const argument = { file: `/files/${name}.glb`, reference, camera, exposure: report.exposure, width: SIZE[0], height: SIZE[1], pictures: look !== undefined };
            const result = await page.evaluate((a) => window.halflightTest.compare(a), argument);
            for (const picture of look ? ['three', 'program'] : [])
                writeFileSync(join(look, `${name}-${picture}.png`), Buffer.from(result[picture], 'base64'));
            console.log(`${name}: mean ${result.mean.toFixed(3)}, p99 ${result.p99.toFixed(2)} of 255 on ${(100 * result.share).toFixed(0)} % of the picture; EV ${report.exposure.toFixed(2)}, ${(100 * report.clipped).toFixed(2)} % clipped, strength ${report.strength.toFixed(2)}`);
            assert.ok(result.share > 0.5, `${name}: surfaces fill ${result.share} of the picture`);
            assert.ok(result.types.length > 0 && result.types.every((t) => t === type), `${name}: ${result.types}`);
            assert.ok(result.mean <= limit, `${name}: mean difference ${result.mean} of 255`);
        }
        await page.close();
        server.close();
    });
}
