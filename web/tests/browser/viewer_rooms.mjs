// Nightly: the viewer with a file that is baked here.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { studio } from './studio.mjs';
import { close, open } from './viewer_page.mjs';

test('the viewer shows a file of a dark room as bright as any, after a bright one', async () => {
    studio.bake('tests/two_rooms', 'two_rooms', '--lightmap-size', '128');
    const viewer = await open('?file=sphere_on_floor.glb&exposure=12');
    await viewer.choose(studio.pathOf('two_rooms'));
    const brightness = await viewer.page.evaluate(
        async (base64) => {
            const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
            const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
            context.drawImage(bitmap, 0, 0);
            const { data } = context.getImageData(330, 0, 330, 320); // beside the panel
            return data.reduce((sum, x, i) => sum + (i % 4 === 3 ? 0 : x), 0) / (0.75 * data.length);
        },
        (await viewer.page.screenshot()).toString('base64')
    );
    assert.ok(brightness > 60 && brightness < 200, `mean level ${brightness}`);
    await close(viewer);
});
