// The program in a worker, which it blocks until main() is done. Files are in memory.
import Halflight from '../wasm/halflight.mjs';

/** Calls `take` with each line that the program writes to a stream. */
function lines(FS, descriptor, take) {
    const stream = FS.getStream(descriptor);
    const decoder = new TextDecoder();
    let rest = '';
    const write = (_, buffer, offset, length) => {
        const whole = (rest + decoder.decode(buffer.slice(offset, offset + length), { stream: true })).split('\n');
        rest = whole.pop();
        whole.forEach(take);
        return length;
    };
    stream.stream_ops = { ...stream.stream_ops, write, close: () => {}, fsync: () => {} };
    stream.tty = null;
}

/** A path from the root without '..', which mkdirTree() does not know. */
function absolute(path) {
    const steps = [];
    for (const step of path.split('/')) {
        if (step === '..') steps.pop();
        else if (step !== '.' && step !== '') steps.push(step);
    }
    return `/${steps.join('/')}`;
}

/** Answers with `send(message, transferred)`: lines and addresses meanwhile, then the exit code and files. */
async function main({ words, files, folder, results, memory, threads }, send) {
    const module = await Halflight({ wasmMemory: memory, threads, thisProgram: 'halflight' });
    const { FS } = module;
    FS.mkdirTree(folder);
    FS.chdir(folder);
    for (const [name, bytes] of Object.entries(files)) {
        const path = absolute(`${folder}/${name}`);
        FS.mkdirTree(path.slice(0, path.lastIndexOf('/')) || '/');
        FS.writeFile(path, bytes);
    }
    lines(FS, 1, () => {});
    lines(FS, 2, (line) => send({ line }));
    send({ state: module._halflightState(), cancelRequested: module._halflightCancelRequested() });
    let code;
    try {
        code = module.callMain(words);
    } catch (error) {
        if (error?.status === undefined) throw error;
        code = error.status;
    }
    const written = code === 0 ? results.map((name) => FS.readFile(`${folder}/${name}`)) : [];
    send({ code, written }, written.map(({ buffer }) => buffer));
}

export const run = (message, send) => main(message, send).catch((error) => send({ broken: String(error?.stack ?? error) }));
