#!/usr/bin/env node
// The command `halflight`: WebAssembly in a worker, while this thread waits for it and for Ctrl-C.
import { rmSync, writeSync } from 'node:fs';
import { cpus } from 'node:os';
import { setFlagsFromString } from 'node:v8';
import { Worker } from 'node:worker_threads';

import { Paths } from '../src/paths.js';

const GRACE_MS = 1000; // as the native program's
const PAGE = 2 ** 16;
const RUNNING = 0;
const CANCELLED = 1;

const given = process.argv.slice(2);
const paths = new Paths();
const words = paths.argumentsOf(given);
const isBake = words[0] === 'bake' && !words.includes('--help') && !words.includes('-h');

// Node 18 compiles all of the program before it runs, unless it is told not to; what is no bake needs little of it.
if (!isBake && parseInt(process.versions.node) < 20) setFlagsFromString('--wasm-lazy-compilation');

/** The number of threads that `bake --threads` asks for; as many are there before the program starts. */
function threadsOf() {
    if (!isBake) return 1;
    const at = words.lastIndexOf('--threads');
    const inline = words.findLast?.((word) => word.startsWith('--threads='))?.slice('--threads='.length);
    const asked = Number(at >= 0 ? words[at + 1] : inline) || Infinity;
    return Math.max(1, Math.min(asked, cpus().length));
}

function say(text) {
    try {
        writeSync(2, text);
    } catch {
        // nobody reads it
    }
}

const missing = paths.missingDrive();
if (missing) {
    say(`halflight: ${missing}: there is no such drive or share\n`);
    process.exit(1);
}

// HALFLIGHT_MEMORY_MB is for tests.
const most = Number(process.env.HALFLIGHT_MEMORY_MB) || 4096;
const memory = new WebAssembly.Memory({ initial: (64 * 2 ** 20) / PAGE, maximum: (most * 2 ** 20) / PAGE, shared: true });
const worker = new Worker(new URL('../src/program.js', import.meta.url), {
    workerData: { words, memory, threads: threadsOf() - 1, mounts: [...paths.mounts], folder: paths.folder, shown: paths.shown },
});

let addresses = null;
worker.on('message', (message) => {
    if (message.code === undefined) addresses = message;
    else process.exit(message.code);
});
worker.on('error', (error) => {
    const full = memory.buffer.byteLength > 0.9 * most * 2 ** 20 || /memory/i.test(String(error?.message));
    if (process.env.HALFLIGHT_TRACE) say(`${error?.stack}\n`);
    removeTemporary();
    say(`halflight: ${full ? `out of memory: WebAssembly has ${most / 1024} GB at most; fewer texels (--texels-per-meter, --lightmap-size) need less` : 'internal error, please report it with this file'}\n`);
    process.exit(1);
});

function removeTemporary() {
    if (!addresses) return;
    const bytes = Buffer.from(memory.buffer, addresses.temporaryFile, 4096);
    const name = Buffer.from(bytes.subarray(0, bytes.indexOf(0))).toString();
    if (!name) return;
    const [at, root] = [...paths.mounts].find(([folder]) => name.startsWith(`${folder}/`)) ?? [paths.folder, paths.userFolder];
    rmSync(name.startsWith('/') ? root + name.slice(at.length) : name, { force: true });
}

/** As the native program: a bake is cancelled, then given a second; all else, and a second time, ends at once. */
function interrupt(signal) {
    process.removeAllListeners(signal);
    const state = addresses && isBake ? new Int32Array(memory.buffer, addresses.state, 1) : null;
    if (!state || Atomics.load(state, 0) === CANCELLED) {
        process.kill(process.pid, paths.windows ? 'SIGKILL' : signal); // Windows can send itself no other
        return;
    }
    if (Atomics.compareExchange(state, 0, RUNNING, CANCELLED) !== RUNNING) return; // it has written its file
    Atomics.store(new Uint8Array(memory.buffer), addresses.cancelRequested, 1);
    setTimeout(() => {
        removeTemporary();
        say('\nhalflight: interrupted\n');
        process.exit(1);
    }, GRACE_MS).unref();
}
process.on('SIGINT', interrupt);
process.on('SIGTERM', interrupt);
if (paths.windows) for (const signal of ['SIGBREAK', 'SIGHUP']) process.on(signal, interrupt); // the latter: a closed console
