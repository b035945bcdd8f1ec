// A copy of web/examples with the packages as npm packs them, and pages of it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, symlinkSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';

import { studio } from '../browser/studio.mjs';
import { halflight, serveFolder, web } from '../harness.mjs';
import { differenceOf } from '../png.mjs';

export const SIZE = { width: 480, height: 270 };
const look = process.env.HALFLIGHT_WEB_PICTURES;
export const examples = join(web, 'examples');
const packed = new Map();

/** Why the tests of frameworks cannot run, null where they can. */
export function missingExamples() {
    const absent = ['examples', 'examples/aframe'].filter((folder) => !existsSync(join(web, folder, 'node_modules/@halflight')));
    return absent.length > 0 ? `no packages found: run npm ci in ${absent.map((folder) => `web/${folder}`).join(' and ')}` : null;
}

/** The packed file of a package of web/. @param {string} name */
export function packageOf(name) {
    if (!packed.has(name)) {
        const options = { cwd: join(web, name), encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] };
        const [{ filename }] = JSON.parse(execFileSync('npm', ['pack', '--json', '--offline', '--pack-destination', studio.files], options));
        packed.set(name, join(studio.files, filename));
    }
    return packed.get(name);
}

/** node_modules with links to those of another folder, but for our packages, which are unpacked. */
function fillModules(folder, source, names) {
    const modules = join(folder, 'node_modules');
    mkdirSync(modules, { recursive: true });
    for (const entry of readdirSync(source)) if (entry !== '@halflight' && !entry.startsWith('.')) symlinkSync(join(source, entry), join(modules, entry));
    for (const name of names) unpackInto(folder, name);
}

/** @param {string} folder with node_modules @param {string} name of a package of web/ */
export function unpackInto(folder, name) {
    const at = join(folder, 'node_modules/@halflight', name);
    mkdirSync(at, { recursive: true });
    execFileSync('tar', ['xzf', packageOf(name), '-C', at, '--strip-components=1']);
}

/** @param {string} name of the folder @returns {string} its path */
export function makeWorkspace(name) {
    const folder = join(studio.files, name);
    const copied = (path) => !path.includes('/node_modules') && basename(path) !== 'dist';
    cpSync(examples, folder, { recursive: true, filter: (path) => copied(path.slice(examples.length)) });
    fillModules(folder, join(examples, 'node_modules'), ['three', 'react']);
    fillModules(join(folder, 'aframe'), join(examples, 'aframe/node_modules'), ['three', 'aframe']);
    return folder;
}

const PROGRAMS = { vite: 'vite/bin/vite.js', tsc: 'typescript/bin/tsc' };

/** Runs a program of a workspace's packages. @param {keyof typeof PROGRAMS} program */
export function runIn(folder, program, ...args) {
    const file = join(folder, 'node_modules', PROGRAMS[program]);
    return execFileSync(process.execPath, [file, ...args], { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
}

/** The program's picture of a baked file as a data URI, and what it printed. */
export function pictureOf(name, { width, height }, ...options) {
    const path = join(studio.files, 'picture.png');
    const fixed = ['--samples', '1', '--penumbrae', 'off', '--shadow-distance', '60', '--shadow-fade-range', '1', '--json'];
    const printed = JSON.parse(halflight('render', studio.pathOf(name), '-o', path, '--size', `${width}x${height}`, ...fixed, ...options));
    return { reference: `data:image/png;base64,${readFileSync(path, 'base64')}`, ...printed };
}

/** Fails where a picture is more than 1.5/255 from the program's. @param {string} ours PNG in base64 */
export async function compare(page, label, ours, reference) {
    if (look) writeFileSync(join(look, `${label}.png`.replaceAll(/[ ,/:]+/g, '-')), Buffer.from(ours, 'base64'));
    const { mean, light } = await page.evaluate(differenceOf, { ours, reference });
    console.log(`${label}: ${mean.toFixed(3)} of 255 from halflight render`);
    assert.ok(light > 20 && mean <= 1.5, `${label}: ${mean} of 255, mean level ${light}`);
}

/** One sample a pixel, as all pictures here; after some frames with the file none is requested, so that a software renderer has time for a picture. */
function watchFrames(least) {
    const getContext = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, options) {
        return getContext.call(this, kind, { ...options, antialias: false });
    };
    const frames = (window.frames_ = { calls: 0, shown: 0, last: 0 });
    for (const name of ['drawElements', 'drawElementsInstanced']) {
        const draw = WebGL2RenderingContext.prototype[name];
        WebGL2RenderingContext.prototype[name] = function (...args) {
            frames.calls += 1;
            return draw.apply(this, args);
        };
    }
    const request = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (act) =>
        request((time) => {
            if (frames.shown >= 4) return;
            frames.calls = 0;
            act(time);
            if (frames.calls < least) return;
            frames.shown += 1;
            frames.last = performance.now();
        });
}

/** Opens a page, waits until it shows a file, and compares. @param {string} folder that is served @param {string} path of the page in it */
export async function comparePage(folder, path, label, reference, drawCalls = 20) {
    const server = await serveFolder(folder);
    const page = await studio.newPage({ viewport: SIZE });
    const trouble = [];
    page.on('pageerror', (error) => trouble.push(String(error)));
    page.on('console', (message) => ['error', 'warning'].includes(message.type()) && !/Failed to load resource|GPU stall/.test(message.text()) && trouble.push(message.text()));
    page.on('response', (response) => response.status() === 404 && !response.url().endsWith('/favicon.ico') && trouble.push(`no ${response.url()}`));
    await page.addInitScript(watchFrames, drawCalls);
    await page.goto(`${server.url}/${path}`);
    try {
        await page.waitForFunction(() => window.frames_.shown >= 4 || (window.frames_.shown > 0 && performance.now() - window.frames_.last > 5000), null, { polling: 500 });
        await compare(page, label, (await page.screenshot()).toString('base64'), reference);
    } catch (error) {
        throw new Error(`${error.message}\n${trouble.join('\n')}`, { cause: error });
    } finally {
        await page.close();
        server.close();
    }
    return trouble;
}
