// bake() of @halflight/bake in Node, and its types.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';

import { repository, web } from '../harness.mjs';
import { halflight, hash, hashOf, scene, workspace } from './workspace.mjs';

const { bake, BakeError } = await import(pathToFileURL(join(workspace(), 'node_modules/@halflight/bake/src/index.js')));
const QUICK = { quality: 'preview', lightmapSize: 64, reflectionProbes: false, probeSpacing: 8 };

test('the bytes are those of the command; progress and the report arrive', async () => {
    const folder = mkdtempSync(join(tmpdir(), 'halflight-'));
    try {
        const result = halflight(['bake', scene('sphere_on_floor'), '-o', join(folder, 'a.glb'), '--quality', 'preview', '-q']);
        assert.equal(result.status, 0, result.stderr);
        const stages = new Set();
        const { glb, report } = await bake(readFileSync(scene('sphere_on_floor')), { quality: 'preview', onProgress: ({ stage, percent }) => percent >= 0 && stages.add(stage) });
        assert.equal(hash(glb), hashOf(join(folder, 'a.glb')));
        assert.ok(['charts', 'lightmap', 'probes'].every((stage) => stages.has(stage)), [...stages].join(', '));
        assert.ok(report.lightmap.charts > 0 && Array.isArray(report.warnings));
    } finally {
        rmSync(folder, { recursive: true });
    }
});

test('a .gltf with files beside it, settings, options of each kind', async () => {
    const bytes = readFileSync(scene('closed_room'));
    const length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.subarray(20, 20 + length));
    json.buffers[0].uri = 'parts/room%201.bin';
    const files = { 'parts/room 1.bin': bytes.subarray(28 + length) };
    const options = { ...QUICK, directional: false, sky: [1, 2, 3], noise: 50, texelStep: 2, exposure: undefined };
    const { report } = await bake(new TextEncoder().encode(JSON.stringify(json)), { ...options, files });
    const whole = (await bake(bytes, options)).report;
    for (const key of ['lightmap', 'probes', 'lights']) assert.deepEqual(report[key], whole[key]);
    const warnings = [];
    await bake(bytes, { ...QUICK, settings: '[[node]]\npattern = "there is none*"\nstatic = false\n', onWarning: (sentence) => warnings.push(sentence) });
    assert.ok(warnings.some((sentence) => sentence.includes('there is none')), warnings.join('\n'));
});

test('what is downloaded is at most 3 MB, compressed', () => {
    const file = join(workspace(), 'node_modules/@halflight/bake/wasm/halflight.wasm');
    const { length } = execFileSync('gzip', ['-9c', file], { maxBuffer: 2 ** 26 });
    console.log(`halflight.wasm: ${length} bytes by gzip`);
    assert.ok(length > 1e6 && length <= 3e6, `${length} bytes`);
});

test('each package has the licence of all that is in its program', () => {
    // Libraries that are linked, headers of templates, what comes with Emscripten, and the functions of mathematics.
    const linked = ['draco', 'embree', 'fmtlib', 'imath', 'libpng1.6', 'libwebp', 'libzstd', 'meshoptimizer', 'onetbb', 'openexr', 'spdlog', 'xxhash', 'zlib'];
    const headers = ['libcli11-dev', 'libdraco-dev', 'libeigen3-dev', 'libglm-dev', 'libstb-dev', 'libtomlplusplus-dev', 'nlohmann-json3-dev'];
    for (const name of ['cli', 'bake']) {
        const folder = join(workspace(), 'node_modules/@halflight', name);
        const texts = readdirSync(join(folder, 'licenses')).sort();
        assert.deepEqual(texts, [...linked, ...headers, 'emscripten', 'mathematics'].map((text) => `${text}.txt`).sort());
        for (const text of texts) assert.match(readFileSync(join(folder, 'licenses', text), 'utf8'), /copyright|licen[cs]e/i, text);
        assert.match(readFileSync(join(folder, 'licenses/mathematics.txt'), 'utf8'), /Arm Limited[\s\S]*Sun Microsystems/);
        assert.match(readFileSync(join(folder, 'LICENSE'), 'utf8'), /^MIT License/);
    }
});

test('errors are the program\'s sentences', async () => {
    const fails = (bytes, options, pattern) => assert.rejects(bake(bytes, options), (error) => error instanceof BakeError && pattern.test(error.message));
    await fails(new TextEncoder().encode('no glTF'), {}, /^[^\n:]*(JSON|glTF)/);
    await fails(readFileSync(scene('closed_room')), { quality: 'best' }, /^--quality: must be one of preview, medium, high, ultra, not 'best'/);
    await fails(readFileSync(scene('closed_room')), { qualty: 'high' }, /^there is no option 'qualty'$/);
    await fails(readFileSync(scene('sphere_on_floor')), { quality: 'high', mostMemory: 66 * 2 ** 20 }, /^out of memory/);
});

test('odd names and files: baked, or refused in a sentence', async () => {
    const bytes = readFileSync(scene('closed_room'));
    const { glb } = await bake(bytes, QUICK);
    const same = async (input, options) => assert.equal(hash((await bake(input, { ...QUICK, ...options })).glb), hash(glb));
    await same(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
    await same(bytes, { name: '-Räume/ein Zimmer.glb', files: { 'a.bin': new ArrayBuffer(4), 'b/c.txt': 'text' } });
    const fails = (input, options, message) => assert.rejects(bake(input, { ...QUICK, ...options }), { name: 'BakeError', message });
    await fails('glTF', {}, 'the scene is neither a Uint8Array nor an ArrayBuffer');
    await fails(undefined, {}, 'the scene is neither a Uint8Array nor an ArrayBuffer');
    await fails(new Uint8Array(0), {}, 'the file is empty');
    await fails(bytes, { name: '' }, "'' is no path beside the scene");
    await fails(bytes, { name: '/dev/null/a.glb' }, "'/dev/null/a.glb' is no path beside the scene");
    await fails(bytes, { files: { 'a.bin': new Blob(['x']) } }, "the file 'a.bin' is neither a Uint8Array nor an ArrayBuffer");
    await fails(bytes, { files: { a: bytes, 'a/b.bin': bytes } }, "'a' is a file and a folder");
});

test('an error of onProgress ends the bake, and is its error', async () => {
    let calls = 0;
    const own = new Error('the bar is gone');
    const onProgress = () => {
        ++calls;
        throw own;
    };
    await assert.rejects(bake(readFileSync(join(repository, 'assets/courtyard.glb')), { onProgress }), (error) => error === own);
    assert.ok(calls >= 1);
});

test('a signal cancels a bake, and one that was aborted before starts none', async () => {
    const bytes = readFileSync(join(repository, 'assets/courtyard.glb'));
    const control = new AbortController();
    const begin = Date.now();
    await assert.rejects(bake(bytes, { signal: control.signal, onProgress: () => control.abort() }), { name: 'AbortError' });
    assert.ok(Date.now() - begin < 60000);
    await assert.rejects(bake(bytes, { signal: AbortSignal.abort(new Error('not now')) }), /not now/);
});

test('two bakes at one time', async () => {
    const bytes = readFileSync(scene('closed_room'));
    const [a, b] = await Promise.all([bake(bytes, QUICK), bake(bytes, { ...QUICK, threads: 1 })]);
    assert.equal(hash(a.glb), hash(b.glb));
});

test('the types fit strict TypeScript, and refuse what is not there', () => {
    const folder = workspace();
    writeFileSync(join(folder, 'use.ts'), `
import { bake, BakeError, type BakeOptions, type BakeResult } from '@halflight/bake';
const options: BakeOptions = { quality: 'preview', texelsPerMeter: 4, directional: false, sky: [1, 1, 1], exposure: 'auto', texelStep: 2, files: {}, signal: AbortSignal.timeout(1000) };
export async function use(bytes: ArrayBuffer): Promise<Blob> {
    const { glb, report }: BakeResult = await bake(bytes, { ...options, onProgress: ({ stage, percent }) => console.log(stage.length + percent) });
    console.log(report.warnings.join('\\n'));
    return new Blob([glb]);
}
// @ts-expect-error there is no such quality
export const wrong: BakeOptions = { quality: 'best' };
export const isOurs = (error: unknown): boolean => error instanceof BakeError && error.message.length > 0;
`);
    const compiler = join(web, 'node_modules/typescript/bin/tsc');
    const words = ['--noEmit', '--strict', '--skipLibCheck', 'false', '--module', 'nodenext', '--target', 'es2022', '--lib', 'es2022,dom', 'use.ts'];
    const { status, stdout } = spawnSync(process.execPath, [compiler, ...words], { cwd: folder, encoding: 'utf8' });
    assert.equal(status, 0, stdout);
});
