// The viewer opens its file. viewer.mjs has the rest.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { close, open } from './viewer_page.mjs';

test('the viewer opens the showcase as its link says, and shows what the file holds', async () => {
    const viewer = await open('#mode=distance-shadowmask&distance=20');
    const { page, text } = viewer;
    assert.equal(await page.inputValue('#modes input:checked'), 'distance-shadowmask');
    assert.equal(await text('#distanceValue'), '20 m');
    const disabled = await page.$$eval(
        '#lights input[type=checkbox]',
        (inputs) => inputs.filter((input) => input.disabled).length
    );
    assert.equal(disabled, 1, 'the fully baked light cannot be switched');
    const statistics = await text('#statistics');
    assert.match(statistics, /draw calls[1-9]/);
    assert.match(statistics, /triangles[1-9]/);
    for (const part of ['lightmaps', 'shadowmasks', 'probes'])
        assert.match(statistics, new RegExp(`${part}[^M]*\\d\\.\\d\\d MB`), part);
    await close(viewer);
});
