// The bake's probes as three.js's own LightProbeGrid: what three.js then draws, against the probes.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { studio } from './studio.mjs';

const grids = [
    ['three', 'webgl', 'LightProbeGridWebGL'],
    ['three', 'webgpu', 'LightProbeGrid'],
    ['three-0.186', 'webgl', 'LightProbeGridWebGL'],
    ['three-0.185', 'webgl', 'LightProbeGrid'],
];
for (const [three, renderer, module] of grids) {
    test(`LightProbeGrid, ${three}, ${renderer}`, async () => {
        const { call } = await studio.pageOf(three, renderer);
        const { result } = await call('probeGrid', { file: '/assets/conformance/proxy_volume.glb', module, resolution: [5, 4, 6] });
        assert.ok(result.some(({ exact }) => exact[0] > 0.1), 'there is light');
        for (const { index, drawn, exact } of result)
            drawn.forEach((x, c) => assert.ok(Math.abs(x - exact[c]) <= 0.01 * exact[c] + 1e-4, `probe ${index}: drawn ${drawn}, exact ${exact}`));
    });
    test(`LightProbeGrid of its own size, ${three}, ${renderer}`, { skip: three !== 'three' }, async () => {
        const { call } = await studio.pageOf(three, renderer);
        const { resolution } = await call('probeGrid', { file: '/assets/conformance/proxy_volume.glb', module });
        assert.ok(resolution.every((n) => n >= 2 && n <= 64), `${resolution}`);
    });
}
