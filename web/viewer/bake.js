// Bakes the file that is open, in the panel's section "Bake". The baker is fetched when the button is pressed first.
import { contentsOf } from './files.js';
import { showNotes } from './panel.js';

/* global HAS_BAKER: build_viewer.mjs says whether the folder holds the baker */

const QUALITIES = ['preview', 'medium', 'high', 'ultra'];
const MODES = ['shadowmask', 'baked-indirect', 'subtractive'];
/** Those that take time, in their order. */
const STAGES = [
    'charts',
    'pack',
    'validity',
    'bounces',
    'lightmap',
    'denoise',
    'shadowmask',
    'probes',
    'reflection probes',
    'write',
];
const DEFAULTS = { quality: 'medium', mode: 'shadowmask' };
const UNSURE_SECONDS = 0.5; // a stage that runs for less tells no time

const element = (id) => document.getElementById(id);
const option = (kind) => (name) =>
    new Option(name === DEFAULTS[kind] ? `${name} (default)` : name, name, false, name === DEFAULTS[kind]);

/** Why this page cannot bake, in a sentence; empty where it can. */
function whyNot() {
    if (!HAS_BAKER) return 'This page was built without the baker: "npx @halflight/cli bake" makes a baked file.';
    if (crossOriginIsolated) return '';
    if (window !== window.top)
        return 'This page is part of another page that is not isolated, so it cannot bake. Open it in a tab.';
    if (!isSecureContext) return 'This page came by http, so it cannot bake: open it by https.';
    return 'This page is not isolated, so it cannot bake. Load it again; its service worker makes it so.';
}

function time(seconds) {
    if (seconds < 90) return `${Math.max(Math.round(seconds), 1)} s`;
    return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

/**
 * What to show of the progress of a bake: its stage, how long that takes from here on, and what follows.
 * @param {string} mode of the bake
 */
function clock(mode) {
    const stages = STAGES.filter((name) => name !== 'shadowmask' || mode === 'shadowmask');
    let stage = '';
    let start = 0;
    let most = 0;
    let done = 0; // of the stages
    return (progress, now) => {
        if (progress.stage !== stage) [stage, start, most] = [progress.stage, now, 0];
        most = Math.max(most, progress.percent); // a stage of several passes begins anew
        done = Math.max(done, stages.indexOf(stage) + 1);
        const seconds = (now - start) / 1000;
        const known = most > 0 && most < 100 && seconds > UNSURE_SECONDS;
        const left = known ? `, ${time((seconds * (100 - most)) / most)} left of this stage` : '';
        const next = done < stages.length ? `Then: ${stages.slice(done).join(', ')}.` : '';
        return { percent: most, text: `${stage}: ${most} %${left}`, next };
    };
}

export class Bakery {
    #source = null;
    #running = null;
    #address = null;

    /**
     * @param {{baked: (glb: Uint8Array<ArrayBuffer>, name: string) => Promise<void>,
     *     failed: (sentence: string) => void, started: () => void}} events
     */
    constructor(events) {
        this.events = events;
        element('quality').replaceChildren(...QUALITIES.map(option('quality')));
        element('bakeMode').replaceChildren(...MODES.map(option('mode')));
        element('bake').addEventListener('click', () => this.#bake());
        element('cancel').addEventListener('click', () => this.cancel());
    }

    cancel() {
        this.#running?.abort();
    }

    /**
     * From now on the section bakes this file; without one there is no section. A bake that runs is given up.
     * @param {import('./files.js').Source | null} source
     */
    offer(source) {
        this.cancel();
        this.#running = null;
        this.#source = source;
        element('bakery').hidden = !source;
        const reason = whyNot();
        element('settings').disabled = reason !== '';
        element('bakeSentence').textContent = reason || 'The bake runs in this page. Your files stay on this computer.';
        this.#show(null);
        this.#finish('', []);
        this.#offerDownload(null);
    }

    /** Only what is not the default, as on a command line. */
    #options() {
        const chosen = { quality: element('quality').value, mode: element('bakeMode').value };
        const options = Object.fromEntries(Object.entries(chosen).filter(([key, value]) => value !== DEFAULTS[key]));
        const texels = element('texels').value;
        return texels === '' ? options : { ...options, texelsPerMeter: Number(texels) };
    }

    async #bake() {
        const source = this.#source;
        const control = (this.#running = new AbortController());
        const isCurrent = () => this.#running === control;
        const start = performance.now();
        const progressOf = clock(element('bakeMode').value);
        const warnings = [];
        this.events.started();
        this.#finish('', []);
        this.#show({ text: 'fetching the baker', next: '' });
        try {
            const { bake } = await import(new URL('./bake/src/index.js', import.meta.url).href).catch(() => {
                throw new Error('the baker cannot be fetched: the network is not reachable');
            });
            const { bytes, files } = await contentsOf(source);
            const { glb } = await bake(bytes, {
                ...this.#options(),
                name: source.name,
                files,
                signal: control.signal,
                onProgress: (progress) => isCurrent() && this.#show(progressOf(progress, performance.now())),
                onWarning: (sentence) => warnings.push(`${sentence[0].toUpperCase()}${sentence.slice(1)}.`),
            });
            if (!isCurrent()) return;
            const name = `${source.name.replace(/\.gl(b|tf)$/i, '')}-baked.glb`;
            this.#finish(`Baked in ${time((performance.now() - start) / 1000)}.`, warnings);
            this.#offerDownload(new File([glb], name, { type: 'model/gltf-binary' }));
            await this.events.baked(glb, name);
        } catch (error) {
            if (!isCurrent()) return;
            const cancelled = control.signal.aborted;
            this.#finish(cancelled ? 'The bake was cancelled.' : '', []);
            if (!cancelled) this.events.failed(`${source.name} cannot be baked: ${error.message}.`);
        }
        this.#running = null;
        this.#show(null);
    }

    /** @param {{text: string, next: string, percent?: number} | null} progress of the bake that runs */
    #show(progress) {
        element('baking').hidden = !progress;
        element('settings').hidden = !HAS_BAKER || progress !== null;
        if (!progress) return;
        element('bakeStage').textContent = progress.text;
        element('bakeNext').textContent = progress.next;
        if (progress.percent === undefined) element('bakeProgress').removeAttribute('value');
        else element('bakeProgress').value = progress.percent;
    }

    #finish(sentence, warnings) {
        element('bakeState').textContent = sentence;
        element('bakeNotes').hidden = warnings.length === 0;
        element('bakeCount').textContent = `What the baker says (${warnings.length})`;
        showNotes(element('bakeWarnings'), warnings);
    }

    /** @param {File | null} file */
    #offerDownload(file) {
        const link = element('download');
        if (this.#address) URL.revokeObjectURL(this.#address);
        this.#address = file && URL.createObjectURL(file);
        link.hidden = !file;
        if (!file) return;
        Object.assign(link, { href: this.#address, download: file.name });
        link.textContent = `Download ${file.name}, ${(file.size / 1e6).toFixed(2)} MB`;
    }
}
