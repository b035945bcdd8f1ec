// Bakes, pictures of the program, and pages to compare with them. Figures are printed; pictures go to HALFLIGHT_WEB_PICTURES
// where it names a folder.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { halflight, launch, openPage, repository, serve } from './harness.mjs';

export const SIZE = [480, 270];
const LIMIT = 1.5; // mean difference in 255ths
const look = process.env.HALFLIGHT_WEB_PICTURES;

export class Studio {
    constructor() {
        this.files = mkdtempSync(join(tmpdir(), 'halflight-web-'));
        this.baked = new Set();
        this.servers = new Map();
        this.pages = new Map();
        this.browser = null;
        if (look) mkdirSync(look, { recursive: true });
    }

    async close() {
        await this.browser?.close();
        for (const server of this.servers.values()) server.close();
        rmSync(this.files, { recursive: true });
    }

    /** The test page with a release of three.js and a renderer of it. */
    async pageOf(three = 'three', renderer = 'webgl') {
        this.browser ??= await launch();
        if (!this.servers.has(three)) this.servers.set(three, await serve(this.files, three));
        const key = `${three} ${renderer}`;
        if (!this.pages.has(key)) this.pages.set(key, await openPage(this.browser, this.servers.get(three).url, renderer));
        return this.pages.get(key);
    }

    bake(scene, name, ...options) {
        if (this.baked.has(name)) return;
        const source = join(repository, 'assets', `${scene}.glb`);
        halflight('bake', source, '-o', join(this.files, `${name}.glb`), '--quality', 'preview', '-q', ...options);
        this.baked.add(name);
    }

    /** The program's picture, and the camera that it was drawn with. */
    reference(name, mode, options) {
        const file = join(this.files, `${name}.glb`);
        const picture = ['-o', join(this.files, 'reference.exr'), '--mode', mode, '--samples', '1', '--size', SIZE.join('x'), '--json'];
        const info = JSON.parse(halflight('render', file, ...picture, ...options));
        return { fov: info.camera.verticalFovDegrees, eye: info.camera.eye, target: info.camera.target };
    }

    /** Draws and compares; a mean difference above the limit fails. */
    async compare(call, label, mode, { name, settings = {}, options = [] }) {
        const { shadowDistance = 60, shadowFadeRange = 1 } = settings;
        const shadow = ['--shadow-distance', String(shadowDistance), '--shadow-fade-range', String(shadowFadeRange)];
        const camera = this.reference(name, mode, [...shadow, ...options]);
        const drawn = await call('draw', { width: SIZE[0], height: SIZE[1], camera, settings: { debugView: 'lit', ...settings, shadowDistance, shadowFadeRange, mode } });
        const result = await call('compare', { reference: '/files/reference.exr', pictures: look !== undefined });
        for (const picture of look ? ['ours', 'reference', 'difference'] : [])
            writeFileSync(join(look, `${label} ${mode} ${picture}.png`.replaceAll(' ', '-')), Buffer.from(result[picture], 'base64'));
        const figures = ['linear', 'encoded', 'median', 'p99'].map((key) => `${key} ${result[key].toFixed(3)}`).join(', ');
        console.log(`${label}, ${mode}: ${figures} of 255; ${drawn.calls} draw calls`);
        assert.ok(result.linear <= LIMIT, `${label}, ${mode}: mean difference ${result.linear} of 255`);
        assert.ok(result.encoded <= LIMIT, `${label}, ${mode}: mean difference ${result.encoded} of 255, sRGB-encoded`);
        return { ...result, ...drawn, camera };
    }
}
