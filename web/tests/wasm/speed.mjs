// What a bake by WebAssembly costs: CPU seconds of the showcase beside the native program's.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import { findProgram, repository } from '../harness.mjs';
import { command, hashOf } from './workspace.mjs';

const native = findProgram();
const folder = mkdtempSync(join(tmpdir(), 'halflight-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

/** Seconds of a processor that a bake of the courtyard takes. */
async function seconds(program, threads, output) {
    const words = ['bake', join(repository, 'assets/courtyard.glb'), '-o', output, '--quality', 'preview', '-q', '--threads', threads];
    const bake = spawn('bash', ['-c', 'TIMEFORMAT="%U %S"; time "$0" "$@"', program, ...words], { stdio: ['ignore', 'ignore', 'pipe'] });
    let said = '';
    bake.stderr.on('data', (data) => (said += data));
    const status = await new Promise((resolve) => bake.on('close', resolve));
    assert.equal(status, 0, said);
    return said.trim().split(' ').reduce((sum, part) => sum + Number(part), 0);
}

test('the courtyard at preview: 1.6 times the native CPU seconds by one thread, 1.8 by two', { skip: !native && 'no native program' }, async () => {
    for (const [threads, most] of [[1, 1.6], [2, 1.8]]) {
        const [own, other] = [`npm ${threads}.glb`, `native ${threads}.glb`].map((name) => join(folder, name));
        // At one time, so that other programs disturb both.
        const [takes, nativeTakes] = await Promise.all([seconds(command(), threads, own), seconds(native, threads, other)]);
        console.log(`${threads} threads: ${takes.toFixed(1)} CPU s, the native program ${nativeTakes.toFixed(1)}: ${(takes / nativeTakes).toFixed(2)} times`);
        console.log(`bytes: ${statSync(own).size}, the native program ${statSync(other).size}`);
        assert.ok(takes <= most * nativeTakes, `${takes} s, natively ${nativeTakes} s`);
    }
    assert.equal(hashOf(join(folder, 'npm 1.glb')), hashOf(join(folder, 'npm 2.glb')));
});
