// The packages as npm would publish them: what is in them, and whether their declarations fit strict TypeScript.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { dirname, join, posix } from 'node:path';
import { test } from 'node:test';

import { web } from './harness.mjs';

const compiler = join(web, 'node_modules/typescript/bin/tsc');
const npm = spawnSync('npm', ['--version'], { encoding: 'utf8' });
const missingPackages = existsSync(compiler) ? null : 'no packages found: run npm install in web/';
if (missingPackages || npm.error) {
    console.log(`[  SKIPPED ] web.packages: ${missingPackages ?? 'npm not found'}`);
    process.exit(0);
}

/** Targets of `exports`, whatever their condition. */
const targetsOf = (exports) => (typeof exports === 'string' ? [exports] : Object.values(exports).flatMap(targetsOf));

const PACKAGES = ['three', 'react', 'aframe', 'gltf-transform'];

/** Packages that a module or its declarations import, without addons' paths. */
const importsOf = (text) =>
    [...text.matchAll(/^(?:import|export)\s+(?:[^;'"]*\sfrom\s*)?['"]([^'".][^'"]*)['"];?$/gm)].map(([, name]) => name.match(/^(?:@[^/]+\/)?[^/]+/)[0]);

for (const folder of PACKAGES) {
    test(`npm pack: @halflight/${folder}`, () => {
        const at = join(web, folder);
        const manifest = JSON.parse(readFileSync(join(at, 'package.json'), 'utf8'));
        const output = execFileSync('npm', ['pack', '--dry-run', '--json', '--offline'], { cwd: at, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] });
        const files = new Set(JSON.parse(output)[0].files.map((file) => file.path));
        for (const name of ['package.json', 'README.md', 'LICENSE']) assert.ok(files.has(name), name);
        for (const target of targetsOf(manifest.exports)) assert.ok(files.has(posix.normalize(target)), `${target} of exports`);
        for (const file of files) {
            assert.ok(!/test|tsconfig|node_modules/.test(file), `${file} is for development`);
            if (!/\.m?[jt]s$/.test(file)) continue;
            for (const name of importsOf(readFileSync(join(at, file), 'utf8')))
                assert.ok(name === manifest.name || manifest.peerDependencies[name], `${file} imports ${name}, which is no peer dependency`);
            if (!/js$/.test(file)) continue;
            for (const match of readFileSync(join(at, file), 'utf8').matchAll(/(?:from|import)\s*['"](\.[^'"]+)['"]/g))
                assert.ok(files.has(posix.join(dirname(file), match[1])), `${file} imports ${match[1]}`);
        }
        for (const key of ['name', 'version', 'description', 'license', 'type', 'keywords', 'peerDependencies']) assert.ok(manifest[key], key);
        assert.equal(manifest.license, 'MIT');
        assert.notEqual(manifest.private, true);
        assert.ok(!manifest.dependencies, 'what an application has already is a peer dependency');
    });
}

test('the packages of WebAssembly have the same version', () => {
    const [three, ...others] = ['three', 'cli', 'bake'].map((folder) => JSON.parse(readFileSync(join(web, folder, 'package.json'), 'utf8')));
    for (const { name, version } of others) assert.equal(version, three.version, name);
});

test('modules that register something are named as having side effects', () => {
    for (const [folder, names] of [['three', ['index.js', 'webgpu.js']], ['aframe', ['index.js']]]) {
        const { sideEffects } = JSON.parse(readFileSync(join(web, folder, 'package.json'), 'utf8'));
        for (const name of names) assert.ok(sideEffects.includes(`./src/${name}`), `bundlers would leave ${name} out`);
    }
});

test('the packages fit each other: versions and releases of three.js', () => {
    const [three, ...others] = ['three', 'react', 'aframe'].map((folder) => JSON.parse(readFileSync(join(web, folder, 'package.json'), 'utf8')));
    for (const { name, version, peerDependencies } of others) {
        assert.equal(version, three.version, name);
        assert.equal(peerDependencies['@halflight/three'], `^${three.version}`, name);
        assert.equal(peerDependencies.three, three.peerDependencies.three, name);
    }
});

test('type declarations: every name of both packages in strict TypeScript', () => {
    const result = spawnSync(process.execPath, [compiler, '-p', join(web, 'tests/types')], { encoding: 'utf8' });
    assert.equal(result.status, 0, result.stdout);
});

test('type declarations name what the modules export', async () => {
    for (const [file, types] of [['three/src/file/read.js', 'three/types/file.d.ts'], ['react/src/index.js', 'react/types/index.d.ts'], ['gltf-transform/src/index.js', 'gltf-transform/src/index.d.ts']]) {
        const declared = [...readFileSync(join(web, types), 'utf8').matchAll(/^export (?:declare )?(?:abstract )?(?:class|function|const) (\w+)/gm)].map((m) => m[1]);
        const source = readFileSync(join(web, file), 'utf8');
        const own = [...source.matchAll(/^export (?:async )?(?:class|function|const) (\w+)/gm)].map((m) => m[1]);
        const passed = [...source.matchAll(/^export \{([^}]*)\}/gm)].flatMap((m) => m[1].split(',').map((name) => name.trim()));
        assert.deepEqual(declared.sort(), [...own, ...passed].filter((name) => name !== 'SurfaceOfNode').sort(), file);
    }
});

test('the packages may be imported where there is no window', () => {
    for (const name of ['three', 'three/webgpu', 'three/file', 'gltf-transform']) {
        const script = `if (typeof window !== 'undefined') throw new Error('a window'); const all = await import('@halflight/${name}'); if (Object.keys(all).length === 0) throw new Error('empty')`;
        const result = spawnSync(process.execPath, ['--input-type=module', '-e', script], { cwd: web, encoding: 'utf8' });
        assert.equal(result.status, 0, `@halflight/${name}: ${result.stderr}`);
    }
});
