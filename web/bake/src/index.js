// bake(): the program `halflight bake` in a worker of its own, with files in memory.
import { cores, notIsolated, startWorker } from '#worker';

import { OPTIONS } from './options.js';

const PAGE = 2 ** 16;
const MOST_BYTES = 2 ** 32; // that 32 bits address
const GRACE_MS = 2000; // to stop by itself, which gives a bake's threads time to leave what they do
const FOLDER = '/bake';
const RUNNING = 0;
const CANCELLED = 1;

/** What the program says of why it did not bake. */
export class BakeError extends Error {
    name = 'BakeError';
}

function wordOf(value, kind) {
    if (kind === 'switch') return value ? 'on' : 'off';
    if (kind === 'percent') return `${value}%`;
    if (kind === 'list') return value.join(',');
    return String(value);
}

/** A file's bytes, whatever holds them. */
function bytesOf(value, name) {
    if (value instanceof Uint8Array) return value;
    if (value instanceof ArrayBuffer) return new Uint8Array(value);
    if (ArrayBuffer.isView(value)) return new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
    throw new BakeError(`${name} is neither a Uint8Array nor an ArrayBuffer`);
}

/** Files by their path beside the scene. */
function filesBeside(files) {
    const all = {};
    for (const [path, value] of Object.entries(files)) {
        if (path === '' || /^\/|\/$/.test(path)) throw new BakeError(`'${path}' is no path beside the scene`);
        all[path] = typeof value === 'string' ? value : bytesOf(value, `the file '${path}'`);
        for (let end = path.indexOf('/'); end >= 0; end = path.indexOf('/', end + 1))
            if (Object.hasOwn(files, path.slice(0, end))) throw new BakeError(`'${path.slice(0, end)}' is a file and a folder`);
    }
    return all;
}

/** The command line of options, and the files that it names. */
function commandOf(bytes, { files = {}, name, settings, ...options }) {
    const isBinary = new TextDecoder('latin1').decode(bytes.subarray(0, 4)) === 'glTF';
    const scene = name ?? (isBinary ? 'scene.glb' : 'scene.gltf');
    const all = { ...files, [scene]: bytes };
    const words = ['bake', '-o', 'halflight-baked.glb', '--report', 'halflight-report.json', '--progress', 'lines'];
    for (const [key, value] of Object.entries(options)) {
        if (value === undefined) continue;
        if (!OPTIONS[key]) throw new BakeError(`there is no option '${key}'`);
        const [option, kind] = OPTIONS[key];
        words.push(option, wordOf(value, kind));
    }
    if (settings !== undefined) {
        all['halflight-settings.toml'] = settings;
        words.push('--settings', 'halflight-settings.toml');
    }
    return { words: [...words, '--', scene], files: filesBeside(all), scene };
}

/** What the program's last line says, without its own name and the scene's. */
function sentenceOf(line, scene) {
    const sentence = line.replace(/^halflight: /, '');
    return sentence.startsWith(`${scene}: `) ? sentence.slice(scene.length + 2) : sentence;
}

/** Threads beside the program's own. */
function threadsOf(options) {
    const most = cores();
    return Math.max(1, Math.min(options.threads || most, most)) - 1;
}

function sharedMemory(mostBytes) {
    try {
        return new WebAssembly.Memory({ initial: (64 * 2 ** 20) / PAGE, maximum: mostBytes / PAGE, shared: true });
    } catch (error) {
        throw new BakeError(`there is no memory to bake in: ${error.message}`);
    }
}

export async function bake(bytes, { onProgress, onWarning, signal, mostMemory = MOST_BYTES, ...options } = {}) {
    signal?.throwIfAborted();
    const reason = notIsolated();
    if (reason) throw new BakeError(reason);
    const { words, files, scene } = commandOf(bytesOf(bytes, 'the scene'), options);
    const memory = sharedMemory(mostMemory);
    let worker, abort, timer;
    try {
        const [glb, report] = await new Promise((resolve, reject) => {
            let addresses = null;
            let last = '';
            const broken = (detail) => {
                const full = memory.buffer.byteLength > 0.9 * mostMemory || /memory/i.test(detail);
                let sentence = `internal error, please report it with this file: ${detail}`;
                if (full) sentence = 'out of memory; fewer texels (texelsPerMeter, lightmapSize) need less';
                else if (/fetch/i.test(detail)) sentence = 'the baker cannot be fetched: the network is not reachable';
                reject(new BakeError(sentence));
            };
            const onLine = (line) => {
                const [, stage, percent] = line.match(/^progress: (.+) (\d+) %$/) ?? [];
                if (stage) onProgress?.({ stage, percent: Number(percent) });
                else if (line.startsWith('halflight: warning: ')) onWarning?.(sentenceOf(line.replace('warning: ', ''), scene));
                else last = line || last;
            };
            abort = () => {
                const state = addresses && new Int32Array(memory.buffer, addresses.state, 1);
                if (state && Atomics.compareExchange(state, 0, RUNNING, CANCELLED) === RUNNING) {
                    Atomics.store(new Uint8Array(memory.buffer), addresses.cancelRequested, 1);
                    timer = setTimeout(() => reject(signal.reason), GRACE_MS);
                } else {
                    reject(signal.reason);
                }
            };
            const onMessage = (message) => {
                if (message.line !== undefined) onLine(message.line);
                else if (message.state !== undefined) addresses = message;
                else if (signal?.aborted) reject(signal.reason);
                else if (message.broken !== undefined) broken(message.broken);
                else if (message.code === 0) resolve(message.written);
                else reject(new BakeError(sentenceOf(last, scene)));
            };
            // An error of the callbacks ends the bake, and is its error.
            const take = (message) => {
                try {
                    onMessage(message);
                } catch (error) {
                    reject(error);
                }
            };
            worker = startWorker(take, (error) => broken(String(error?.message ?? error)));
            signal?.addEventListener('abort', abort, { once: true });
            worker.postMessage({ words, files, folder: FOLDER, results: ['halflight-baked.glb', 'halflight-report.json'], memory, threads: threadsOf(options) });
        });
        return { glb, report: JSON.parse(new TextDecoder().decode(report)) };
    } finally {
        clearTimeout(timer);
        signal?.removeEventListener('abort', abort);
        worker?.terminate();
    }
}
