// Files as tools leave them: pictures beside the document, geometry and pictures made small, and what glTF Transform's commands write.
// Each must draw as the program draws the file that it was made of.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, realpathSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { readGlb } from '../glb.mjs';
import { halflight, web } from '../harness.mjs';
import { studio } from './studio.mjs';

/** A binary file as a JSON document with its buffer and images beside it, the last image inside as a data URI. */
function unpack(glb, name) {
    const { json, buffer } = readGlb(glb);
    json.buffers[0].uri = `${name}.bin`;
    writeFileSync(join(studio.files, `${name}.bin`), buffer);
    json.images.forEach((image, i) => {
        const view = json.bufferViews[image.bufferView];
        const own = buffer.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
        delete image.bufferView;
        if (i === json.images.length - 1) {
            image.uri = `data:${image.mimeType};base64,${own.toString('base64')}`;
        } else {
            image.uri = `${name} image ${i}`.replaceAll(' ', '%20');
            writeFileSync(join(studio.files, `${name} image ${i}`), own);
        }
        delete image.mimeType; // a file beside has its own type
    });
    writeFileSync(join(studio.files, `${name}.gltf`), JSON.stringify(json));
}

/** Loads a file of the run and compares its picture with the program's of `original`. */
async function drawsAs(file, original, label, renderer = 'webgl') {
    const { call } = await studio.pageOf('three', renderer);
    const loaded = await call('load', { file: `/files/${file}` });
    const result = await studio.compare(call, label, 'shadowmask', { name: original });
    return { ...loaded, ...result };
}

test('pictures given by URI, relative or data', async () => {
    unpack(studio.pathOf('conformance/bumpy_wall'), 'unpacked');
    for (const renderer of ['webgl', 'webgpu']) await drawsAs('unpacked.gltf', 'conformance/bumpy_wall', `pictures by URI, ${renderer}`, renderer);
});

for (const [name, label] of [['conformance/bumpy_wall', 'directional lightmap'], ['conformance/proxy_volume', 'probes'], ['instances', 'instances']]) {
    test(`halflight optimize: ${label}`, async () => {
        if (name === 'instances') studio.bake('tests/instances_1023', name, '--lightmap-size', '256');
        const small = join(studio.files, 'small.glb');
        halflight('optimize', studio.pathOf(name), small);
        const { bytes, cellsOfFile } = await drawsAs('small.glb', name, `optimized ${label}`);
        assert.ok(cellsOfFile, 'neighbours follow from the tetrahedra');
        const size = statSync(small).size;
        const parts = Object.values(bytes).reduce((a, b) => a + b, 0);
        assert.ok(parts > 0 && parts < size, `parts of ${parts} bytes in a file of ${size}`);
    });
}

const transform = join(web, 'node_modules/.bin/gltf-transform');
/** Lossy WebP changes the application's own textures, so the program draws that file too. */
const commands = [['optimize'], ['optimize', '--texture-compress', 'webp'], ['prune'], ['dedup'], ['webp'], ['meshopt'], ['draco'], ['quantize']];
for (const command of commands) {
    test(`gltf-transform ${command.join(' ')}`, { skip: existsSync(transform) ? false : 'the npm package @gltf-transform/cli is not installed' }, async () => {
        const [tool, ...options] = command;
        const name = `transformed by ${command.join(' ')}`;
        const config = join(web, 'gltf-transform/halflight.config.mjs');
        execFileSync(process.execPath, [realpathSync(transform), tool, studio.pathOf('conformance/bumpy_wall'), studio.pathOf(name), ...options, '--config', config], { stdio: 'pipe' });
        const { call } = await studio.pageOf('three');
        const { bytes: before } = await studio.load(call, 'conformance/bumpy_wall');
        const { bytes } = await drawsAs(`${name}.glb`, command.includes('webp') ? name : 'conformance/bumpy_wall', `gltf-transform ${command.join(' ')}`);
        for (const part of ['lightmaps', 'directions', 'masks']) assert.equal(bytes[part], before[part], `${part} stay as they are`);
    });
}
