// A worker of Node, with the few calls of a browser's that are used.
import { cpus } from 'node:os';
import { Worker } from 'node:worker_threads';

export const cores = () => cpus().length;

export const notIsolated = () => null;

export function startWorker(onMessage, onError) {
    const worker = new Worker(new URL('./program_node.js', import.meta.url));
    worker.on('message', onMessage).on('error', onError);
    return worker;
}
