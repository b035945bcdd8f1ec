// Every KTX2 that the program writes, read by ktx-parse: in baked files, beside them, and by `optimize`.
import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { readGlb } from './glb.mjs';
import { findProgram, halflight, repository, web } from './harness.mjs';

const missing = !existsSync(join(web, 'node_modules/ktx-parse'))
    ? 'no packages found: run npm install in web/'
    : !findProgram() && 'no halflight program found: build it, or set HALFLIGHT_PROGRAM';
if (missing) {
    console.log(`[  SKIPPED ] web.ktx2: ${missing}`);
    process.exit(0);
}
const { read, KHR_DF_MODEL_RGBSDA, KHR_DF_TRANSFER_LINEAR, KHR_SUPERCOMPRESSION_ZSTD, VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, VK_FORMAT_R16G16B16A16_SFLOAT } =
    await import('ktx-parse');

const folder = mkdtempSync(join(tmpdir(), 'halflight_ktx2_'));
after(() => rmSync(folder, { recursive: true }));
const at = (name) => join(folder, name);
const scene = join(repository, 'assets/tests/sphere_on_floor.glb');
const fast = ['--quality', 'preview', '--samples', '16', '--lightmap-size', '64'];

/** `--lightmap-format`, its Vulkan format, and bytes a texel. */
const formats = [
    ['rgb9e5', VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, 4],
    ['half', VK_FORMAT_R16G16B16A16_SFLOAT, 8],
];

/** The KTX2 images in a .glb, by what they are: reflection probes are RGB9E5 whatever the lightmaps are. */
function picturesOf(path) {
    const { json, buffer } = readGlb(path);
    const bytesOf = (image) => {
        const view = json.bufferViews[image.bufferView];
        return new Uint8Array(buffer.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength));
    };
    const pictures = (json.images ?? []).filter((image) => image.mimeType === 'image/ktx2');
    const ofReflections = (image) => image.name.endsWith('reflection probes');
    return {
        lightmaps: pictures.filter((image) => !ofReflections(image)).map(bytesOf),
        reflections: pictures.filter(ofReflections).map(bytesOf),
    };
}

/** One level of linear floats, Zstandard-compressed, whose stated sizes fit each other. */
function check(bytes, vkFormat, bytesPerTexel) {
    const file = read(bytes);
    assert.equal(file.vkFormat, vkFormat);
    assert.equal(file.supercompressionScheme, KHR_SUPERCOMPRESSION_ZSTD);
    assert.deepEqual([file.pixelDepth, file.layerCount, file.faceCount, file.levels.length], [0, 0, 1, 1]);
    assert.ok(file.pixelWidth > 0 && file.pixelHeight > 0);
    const [level] = file.levels;
    assert.equal(level.uncompressedByteLength, file.pixelWidth * file.pixelHeight * bytesPerTexel);
    assert.equal(Buffer.from(level.levelData).readUInt32LE(0), 0xfd2fb528, 'a Zstandard frame');
    const [descriptor] = file.dataFormatDescriptor;
    assert.equal(descriptor.colorModel, KHR_DF_MODEL_RGBSDA);
    assert.equal(descriptor.transferFunction, KHR_DF_TRANSFER_LINEAR);
    assert.ok(file.keyValue.KTXwriter, 'the writer names itself');
}

test('lightmaps of baked files, and of optimize', () => {
    for (const [format, vkFormat, size] of formats) {
        halflight('bake', scene, '-o', at(`${format}.glb`), '--lightmap-format', format, ...fast);
        const { lightmaps, reflections } = picturesOf(at(`${format}.glb`));
        assert.ok(lightmaps.length > 0, format);
        for (const bytes of lightmaps) check(bytes, vkFormat, size);
        assert.equal(reflections.length, 1, format);
        check(reflections[0], VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, 4);
    }
    halflight('optimize', at('rgb9e5.glb'), at('small.glb'), '--lightmap-format', 'rgb9e5');
    const { lightmaps, reflections } = picturesOf(at('small.glb'));
    assert.ok(lightmaps.length > 0, 'optimize');
    assert.equal(reflections.length, 1, 'optimize');
    for (const bytes of [...lightmaps, ...reflections]) check(bytes, VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, 4);
});

test('lightmaps of a sidecar', () => {
    for (const [format, vkFormat, size] of formats) {
        halflight('bake', scene, '-o', at('beside.glb'), '--sidecar', at(format), '--lightmap-format', format, ...fast);
        const names = readdirSync(at(format)).filter((name) => name.endsWith('.ktx2'));
        assert.ok(names.length > 0, format);
        for (const name of names) check(new Uint8Array(readFileSync(join(at(format), name))), vkFormat, size);
    }
});

test('ktx-parse refuses what is not KTX2', () => {
    assert.throws(() => read(new Uint8Array(80)));
});
