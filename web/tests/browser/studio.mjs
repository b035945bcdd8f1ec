// Bakes, pictures of the program, and pages to compare with them. Figures are printed; pictures go to HALFLIGHT_WEB_PICTURES
// where it names a folder.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after } from 'node:test';

import { halflight, launch, newPage, openPage, repository, serve } from '../harness.mjs';

export const SIZE = [320, 180];
const LIMIT = 1.5; // mean difference in 255ths
/** Functions of the page that leave its scene as it was loaded. */
const KEEPING = new Set(['draw', 'compare', 'picture', 'agreement', 'atPoints', 'lightNames', 'intensityOf', 'sentences', 'evaluate', 'toneMapping']);
const look = process.env.HALFLIGHT_WEB_PICTURES;

class Studio {
    constructor() {
        this.files = mkdtempSync(join(tmpdir(), 'halflight-web-'));
        this.baked = new Set();
        this.references = new Map();
        this.servers = new Map();
        this.pages = new Map();
        this.loaded = new Map(); // by page's call: a file stays with its compiled programs from one test to the next
        this.browser = null;
        if (look) mkdirSync(look, { recursive: true });
    }

    async close() {
        await this.browser?.close();
        for (const server of this.servers.values()) server.close();
        rmSync(this.files, { recursive: true });
    }

    async newPage(options) {
        this.browser ??= await launch();
        return newPage(this.browser, options);
    }

    /** A server with a release of three.js. */
    async urlOf(three) {
        if (!this.servers.has(three)) this.servers.set(three, await serve(this.files, three));
        return this.servers.get(three).url;
    }

    /** The test page with a release of three.js and a renderer of it. */
    async pageOf(three = 'three', renderer = 'webgl') {
        this.browser ??= await launch();
        const url = await this.urlOf(three);
        const key = `${three} ${renderer}`;
        if (!this.pages.has(key)) {
            const opened = await openPage(this.browser, url, renderer);
            const call = (name, argument) => {
                if (!KEEPING.has(name)) this.loaded.delete(call);
                return opened.call(name, argument);
            };
            this.pages.set(key, { ...opened, call });
        }
        return this.pages.get(key);
    }

    bake(scene, name, ...options) {
        if (this.baked.has(name)) return;
        const source = join(repository, 'assets', `${scene}.glb`);
        halflight('bake', source, '-o', join(this.files, `${name}.glb`), '--quality', 'preview', '-q', ...options);
        this.baked.add(name);
    }

    /** @param {string} name of a bake or other file of the run, or "conformance/NAME" */
    pathOf(name) {
        return name.startsWith('conformance/') ? join(repository, 'assets', `${name}.glb`) : join(this.files, `${name}.glb`);
    }

    /** Loads a file into a page, unless it is there as it was loaded. @param {(name: string, argument: any) => Promise<any>} call */
    async load(call, name, options) {
        const key = JSON.stringify([name, options]);
        if (this.loaded.get(call)?.key !== key) {
            const result = await call('load', { file: `${name.startsWith('conformance/') ? '/assets' : '/files'}/${name}.glb`, options });
            this.loaded.set(call, { key, result });
        }
        return this.loaded.get(call).result;
    }

    /** The program's picture, and the camera that it was drawn with; each picture is made once. */
    reference(name, mode, options = [], size = SIZE) {
        const key = [name, mode, ...options, ...size].join(' ');
        if (!this.references.has(key)) {
            const picture = `reference${this.references.size}.exr`;
            const output = ['-o', join(this.files, picture), '--mode', mode, '--samples', '1', '--penumbrae', 'off', '--size', size.join('x'), '--json'];
            const { camera } = JSON.parse(halflight('render', this.pathOf(name), ...output, ...options));
            this.references.set(key, { url: `/files/${picture}`, camera: { fov: camera.verticalFovDegrees, eye: camera.eye, target: camera.target } });
        }
        return this.references.get(key);
    }

    /** Draws and compares; a mean difference above the limit fails. @param {string} name of the file whose picture by the program is the reference */
    async compare(call, label, mode, { name, settings = {}, options = [], size = SIZE }) {
        const { shadowDistance = 60, shadowFadeRange = 1 } = settings;
        const shadow = ['--shadow-distance', String(shadowDistance), '--shadow-fade-range', String(shadowFadeRange)];
        const { url, camera } = this.reference(name, mode, [...shadow, ...options], size);
        return this.compareWith(call, `${label}, ${mode}`, { reference: url, camera, size, settings: { debugView: 'lit', ...settings, shadowDistance, shadowFadeRange, mode } });
    }

    async compareWith(call, label, { reference, camera, size, settings }) {
        const drawn = await call('draw', { width: size[0], height: size[1], camera, settings });
        const result = await call('compare', { reference, pictures: look !== undefined });
        for (const picture of look ? ['ours', 'reference', 'difference'] : [])
            writeFileSync(join(look, `${label} ${picture}.png`.replaceAll(/[ ,/]+/g, '-')), Buffer.from(result[picture], 'base64'));
        const figures = ['linear', 'encoded', 'median', 'p99'].map((key) => `${key} ${result[key].toFixed(3)}`).join(', ');
        console.log(`${label}: ${figures} of 255; ${(100 * result.even).toFixed(2)} % of ${result.evenPixels} even pixels within 1 %; ${drawn.calls} draw calls`);
        assert.ok(result.linear <= LIMIT, `${label}: mean difference ${result.linear} of 255`);
        assert.ok(result.encoded <= LIMIT, `${label}: mean difference ${result.encoded} of 255, sRGB-encoded`);
        return { ...result, ...drawn, camera };
    }
}

/** One browser for all tests of a run: its pages, bakes and the program's pictures are shared. */
export const studio = new Studio();
after(() => studio.close());
