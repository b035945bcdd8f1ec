// The worker in which the program runs: it blocks until main() is done.
import { writeSync } from 'node:fs';
import { isatty } from 'node:tty';
import { parentPort, workerData } from 'node:worker_threads';

import Halflight from '../wasm/halflight.mjs';
import { Paths } from './paths.js';

const { words, memory, threads, mounts, folder, shown } = workerData;

/** WASI's numbers of what may go wrong with a standard stream. */
const ERRORS = { EBADF: 8, ENOSPC: 51, EPIPE: 64 };
const EIO = 29;

/** Writes to a stream of this process at once, also where it is a pipe that is full. */
function writeAll(descriptor, bytes) {
    for (let done = 0; done < bytes.length;) {
        try {
            done += writeSync(descriptor, bytes, done);
        } catch (error) {
            if (error.code !== 'EAGAIN') throw error;
            Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 5);
        }
    }
}

/** Connects a stream of the program. Text is written whole where paths in it have other names for the user. */
function connect(FS, descriptor) {
    const stream = FS.getStream(descriptor);
    const kept = [];
    const send = (bytes) => writeAll(descriptor, bytes);
    const write = (bytes) => {
        if (shown.size === 0) send(bytes);
        else if (descriptor === 1) kept.push(bytes); // a line may come in parts
        else send(Buffer.from(Paths.show(Buffer.from(bytes).toString(), shown)));
    };
    stream.stream_ops = {
        ...stream.stream_ops,
        write: (_, buffer, offset, length) => {
            try {
                write(new Uint8Array(buffer.buffer, offset, length).slice()); // of its own memory, not the threads'
            } catch (error) {
                throw new FS.ErrnoError(ERRORS[error.code] ?? EIO);
            }
            return length;
        },
        close: () => {},
        fsync: () => {},
    };
    if (!isatty(descriptor)) stream.tty = null;
    return () => kept.length > 0 && send(Buffer.from(Paths.show(Buffer.concat(kept).toString(), shown)));
}

function mount(FS) {
    const { NODEFS } = FS.filesystems;
    for (const [at, root] of mounts) {
        FS.mkdirTree(at);
        FS.mount(NODEFS, { root }, at);
    }
    FS.chdir(folder);
}

const module = await Halflight({ wasmMemory: memory, threads, thisProgram: 'halflight' });
mount(module.FS);
const finish = [1, 2].map((descriptor) => connect(module.FS, descriptor));
parentPort.postMessage({
    state: module._halflightState(),
    cancelRequested: module._halflightCancelRequested(),
    temporaryFile: module._halflightTemporaryFile(),
});
let code;
try {
    code = module.callMain(words);
} catch (error) {
    if (error?.status === undefined) throw error;
    code = error.status;
}
try {
    for (const last of finish) last();
} catch (error) {
    if (code === 0) writeAll(2, Buffer.from(`halflight: standard output cannot be written (${error.message})\n`));
    code ||= 1;
}
parentPort.postMessage({ code });
