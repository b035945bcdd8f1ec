export const cores = () => navigator.hardwareConcurrency;

/** Why the page has no memory that threads share; null where it has. */
export const notIsolated = () =>
    globalThis.crossOriginIsolated
        ? null
        : "this page is not isolated, so it cannot bake: send it with the headers 'Cross-Origin-Opener-Policy: same-origin' and 'Cross-Origin-Embedder-Policy: require-corp', or load isolate.js of @halflight/bake, a service worker that adds them";

export function startWorker(onMessage, onError) {
    const worker = new Worker(new URL('./program_web.js', import.meta.url), { type: 'module', name: 'halflight' });
    worker.onmessage = (event) => onMessage(event.data);
    worker.onerror = (event) => onError(event.error ?? new Error(event.message ?? 'the worker cannot be fetched'));
    return worker;
}
