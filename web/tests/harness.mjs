// Headless Chromium, a local server of this folder, and pictures of the program to compare with.
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

export const web = join(dirname(fileURLToPath(import.meta.url)), '..');
export const repository = join(web, '..');

/** The browser of the environment, of Debian, or none. */
export function findChromium() {
    const candidates = [process.env.HALFLIGHT_CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];
    return candidates.find((path) => path && existsSync(path)) ?? null;
}

/** The halflight program of the environment or of a build. */
export function findProgram() {
    const builds = ['dev', 'release', 'asan'].map((preset) => join(repository, 'build', preset, 'apps/halflight/halflight'));
    return [process.env.HALFLIGHT_PROGRAM, ...builds].find((path) => path && existsSync(path)) ?? null;
}

/** Why pictures cannot be drawn, null where they can. @param {{program?: boolean}} [needs] whether the program draws some */
export function missing({ program = true } = {}) {
    if (!findChromium()) return 'no Chromium found: install the package chromium';
    if (!existsSync(join(web, 'node_modules/three'))) return 'no packages found: run npm install in web/';
    if (program && !findProgram()) return 'no halflight program found: build it, or set HALFLIGHT_PROGRAM';
    return null;
}

export function halflight(...args) {
    return execFileSync(findProgram(), args, { encoding: 'utf8', maxBuffer: 2 ** 26 });
}

const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.json': 'application/json', '.svg': 'image/svg+xml', '.wasm': 'application/wasm' };

/** Serves web/ as /web/, assets/ as /assets/, a package of three.js as /three/, a folder of files as /files/, and others. */
export function serve(files, three = 'three', others = {}) {
    return serveRoots({ '/three/': join(web, 'node_modules', three), '/files/': files, '/web/': web, '/assets/': join(repository, 'assets'), ...others });
}

/** Serves one folder as /. */
export function serveFolder(folder) {
    return serveRoots({ '/': folder });
}

async function serveRoots(roots) {
    const server = createServer((request, response) => {
        const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
        const prefix = Object.keys(roots).find((p) => path.startsWith(p));
        const file = prefix && join(roots[prefix], path.slice(prefix.length));
        if (!file || !existsSync(file) || !statSync(file).isFile()) {
            response.writeHead(404).end();
            return;
        }
        response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream' }).end(readFileSync(file));
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
    return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

/** Chromium whose WebGL and WebGPU run on SwiftShader, the same on every machine. */
export async function launch() {
    const { chromium } = await import('playwright-core');
    const flags = [
        '--no-sandbox', '--enable-unsafe-webgpu', '--enable-features=Vulkan', '--use-vulkan=swiftshader',
        '--use-angle=swiftshader', '--ignore-gpu-blocklist',
    ];
    return chromium.launch({ executablePath: findChromium(), args: flags });
}

/** A page whose waits last three minutes: a busy machine takes more than Playwright's half a minute to load one. */
export async function newPage(browser, options = {}) {
    const page = await browser.newPage(options);
    page.setDefaultTimeout(180000);
    return page;
}

/** The test page, with its errors thrown here. */
export async function openPage(browser, url, renderer = 'webgl') {
    const page = await newPage(browser);
    const errors = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('console', (message) => {
        if ((message.type() === 'error' && !message.text().includes('favicon')) || process.env.HALFLIGHT_WEB_VERBOSE) errors.push(message.text());
    });
    await page.goto(`${url}/web/tests/page/${renderer === 'webgl' ? 'index' : 'webgpu'}.html?renderer=${renderer}`);
    await page.waitForFunction('window.ready === true').catch((error) => {
        throw new Error(`${error}\n${errors.join('\n')}`);
    });
    const call = async (name, argument) => {
        errors.length = 0;
        const result = await page.evaluate(([n, a]) => window.halflightTest[n](a), [name, argument]);
        if (errors.length > 0) throw new Error(errors.join('\n').slice(0, 4000));
        return result;
    };
    return { page, call };
}
