// The viewer's folder, as build_viewer.mjs makes it, served without any other network, and a page of it.
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after } from 'node:test';

import { repository, serveFolder, web } from '../harness.mjs';
import { studio } from './studio.mjs';

export const folder = mkdtempSync(join(tmpdir(), 'halflight-viewer-'));
export const conformance = join(repository, 'assets/conformance');
let server = null;
after(() => {
    server?.close();
    rmSync(folder, { recursive: true });
});

async function serve() {
    execFileSync(process.execPath, [
        join(web, 'scripts/build_viewer.mjs'),
        folder,
        join(conformance, 'five_lights.glb'),
        '--no-baker',
    ]);
    for (const name of ['sphere_on_floor.glb', 'avenue.glb']) copyFileSync(join(conformance, name), join(folder, name));
    writeFileSync(join(folder, 'plain.glb'), 'not glTF');
    return serveFolder(folder);
}

/** Waits for the whole picture of the file that is open. */
const whole = (page) =>
    page.waitForFunction(() => document.body.dataset.picture === 'whole' && document.body.dataset.frames > 1);

/**
 * @param {string} address of the file and the view; the showcase where it names no file
 * @param {{script?: () => void, drawn?: boolean, [option: string]: any}} options of the page; `script` runs before it;
 *     with `drawn: false` no picture comes
 */
export async function open(address = '?file=sphere_on_floor.glb', { script, drawn: comes = true, ...options } = {}) {
    server ??= serve();
    server = await server;
    const page = await studio.newPage({ viewport: { width: 660, height: 320 }, ...options });
    const errors = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('request', (request) => {
        const own = request.url().startsWith(server.url) || /^(data|blob):/.test(request.url());
        if (!own) errors.push(`asks for ${request.url()}`);
    });
    if (script) await page.addInitScript(script);
    await page.goto(`${server.url}/index.html${address}`);
    const frames = () => page.evaluate(() => Number(document.body.dataset.frames ?? 0));
    /** Waits for a frame after `act`; a frame that an earlier change requested is drawn before it. */
    const drawn = async (act = async () => {}) => {
        await page.evaluate(
            () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)))
        );
        const before = await frames();
        await act();
        await page.waitForFunction((n) => Number(document.body.dataset.frames ?? 0) > n, before);
    };
    /** Opens files of this computer by choice, and waits for the picture. @param {string[]} paths */
    const choose = async (...paths) => {
        await drawn(() => page.setInputFiles('#open', paths));
        await whole(page);
    };
    if (comes) await whole(page);
    const link = async () => {
        await page.click('#link');
        return new URLSearchParams(await page.evaluate(() => location.hash.slice(1)));
    };
    const text = (selector) => page.evaluate((s) => document.querySelector(s).textContent, selector);
    const says = (selector, part) =>
        page.waitForFunction(([s, p]) => document.querySelector(s).textContent.includes(p), [selector, part]);
    return {
        page,
        errors,
        drawn,
        choose,
        whole: () => whole(page),
        link,
        text,
        says,
        url: server.url,
        picture: () => page.locator('#picture').screenshot(),
    };
}

/** Closes a page on which nothing went wrong. */
export async function close({ page, errors }) {
    await page.close();
    if (errors.length > 0) throw new Error(errors.join('\n'));
}

/** Drops files on the page. @param {{name: string, path: string}[]} files */
export async function drop(page, read, files) {
    const parts = files.map(({ name, path }) => ({ name, base64: read(path).toString('base64') }));
    await page.evaluate(async (list) => {
        const dataTransfer = new DataTransfer();
        for (const { name, base64 } of list) {
            const blob = await (await fetch(`data:application/octet-stream;base64,${base64}`)).blob();
            dataTransfer.items.add(new File([blob], name));
        }
        document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    }, parts);
}
