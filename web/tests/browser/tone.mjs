// The program's displayed pictures have the tone mappers of three.js.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';

import { halflight } from '../harness.mjs';
import { studio } from './studio.mjs';

test('tone mapping: --tone-mapping as three.js has it', async () => {
    const { call } = await studio.pageOf('three', 'webgl');
    await studio.load(call, 'conformance/five_lights');
    const render = (file, ...options) =>
        halflight('render', studio.pathOf('conformance/five_lights'), '-o', join(studio.files, file), '--samples', '1', '--size', '160x90', ...options);
    render('radiance.exr');
    const pictures = new Set();
    for (const name of ['neutral', 'aces', 'agx', 'none']) {
        render(`${name}.png`, '--tone-mapping', name, '--exposure', '-1');
        const { most, mean, level } = await call('toneMapping', { radiance: '/files/radiance.exr', picture: `/files/${name}.png`, name, exposure: 2 });
        console.log(`${name}: ${most} of 255 off at most, ${mean.toFixed(4)} on average; mean level ${level.toFixed(2)}`);
        assert.ok(most <= 1 && mean < 0.05, `${name}: ${most} at most, ${mean} on average`); // roundings
        pictures.add(level.toFixed(2));
    }
    assert.equal(pictures.size, 4, 'each has another picture');
});
