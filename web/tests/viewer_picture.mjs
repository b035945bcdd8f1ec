// The viewer's picture against the program's, from the same camera.
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { halflight } from './harness.mjs';
import { differenceOf } from './png.mjs';

/** A screenshot of the picture alone. */
export const pictureOf = (page) => page.screenshot({ style: 'aside, #beside, #message { display: none !important }' });

/**
 * Mean difference, in 255ths, of what a page shows and of what `halflight render` makes of a file.
 * @param {string} file that the program draws
 */
export async function differenceFromProgram(page, file) {
    await page.evaluate(() => document.querySelector('#link').click());
    const view = new URLSearchParams(await page.evaluate(() => location.hash.slice(1)));
    const { width, height } = page.viewportSize();
    const folder = mkdtempSync(join(tmpdir(), 'halflight-picture-'));
    try {
        const output = join(folder, 'render.png');
        const camera = ['eye', 'target', 'fov', 'mode', 'exposure'].flatMap((name) => [`--${name}`, view.get(name)]);
        halflight('render', file, '-o', output, '--size', `${width}x${height}`, '--penumbrae', 'off', ...camera);
        const reference = `data:image/png;base64,${readFileSync(output).toString('base64')}`;
        return await page.evaluate(differenceOf, { ours: (await pictureOf(page)).toString('base64'), reference });
    } finally {
        rmSync(folder, { recursive: true });
    }
}
