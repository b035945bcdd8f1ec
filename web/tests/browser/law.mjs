// The law and the other formulas of the shading headers on the graphics device, in each of the languages that they become:
// against the conformance table, and in random cases against JavaScript.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import glsl from '../../three/src/generated/shading.glsl.js';
import * as js from '../../three/src/generated/shading.js';
import { repository } from '../harness.mjs';
import { randomizer } from '../random.mjs';
import { studio } from './studio.mjs';

const table = JSON.parse(readFileSync(join(repository, 'assets/conformance/law.json'), 'utf8'));
const capital = (name) => name[0].toUpperCase() + name.slice(1);

/** Types of a function's parameters and of its result, as the generated GLSL declares them. */
function signatureOf(name) {
    const match = new RegExp(`^(\\w+) hl${capital(name)}\\(([^)]*)\\)`, 'm').exec(glsl);
    assert.ok(match, `the generated text has ${name}`);
    return { name: capital(name), result: match[1], types: match[2].split(',').map((parameter) => parameter.trim().split(' ')[0]) };
}

function check(label, cases, results) {
    let worst = 0;
    results.forEach((result, i) => {
        const expected = [cases[i].at(-1)].flat();
        expected.forEach((e, c) => {
            const limit = table.relativeTolerance * Math.abs(e) + table.absoluteTolerance;
            worst = Math.max(worst, Math.abs(result[c] - e) / limit);
            assert.ok(Math.abs(result[c] - e) <= limit, `${label}(${JSON.stringify(cases[i].slice(0, -1))}) is ${result[c]}, not ${e}`);
        });
    });
    return worst;
}

const random = randomizer(7);
/** 0 and 1 as often as all between: edges of the law are where languages differ. */
const share = () => [0, 1, random(1), random(1)][Math.floor(random(4))];
const flag = () => random(2) < 1;
const unit = () => {
    const v = [random(2) - 1, random(2) - 1, random(2) - 1];
    const length = Math.hypot(...v);
    return v.map((x) => Math.fround(x / length));
};
const single = (values) => values.map((x) => (typeof x === 'number' ? Math.fround(x) : x));
const makers = {
    mixShadows: () => [Math.floor(random(5)), flag(), share(), flag(), share(), share(), share()],
    bakedWithinReach: () => [share(), random(20), random(20), random(2) - 1, flag() ? -2 : random(2) - 1],
    decodeMask: () => [share(), flag() ? 0 : 0.25 + random(8), random(2), random(3)],
    distanceAttenuation: () => [0.01 + random(20), flag() ? 0 : 0.1 + random(20)],
    shIrradianceWeight: () => [Math.floor(random(9)), unit()],
};
const vector = (x) => (Array.isArray(x) ? { x: x[0], y: x[1], z: x[2] } : x);
const randomCases = Object.fromEntries(
    Object.entries(makers).map(([name, make]) => [name, Array.from({ length: 4096 }, () => single(make())).map((list) => [...list, js[name](...list.map(vector))])])
);

for (const renderer of ['webgl', 'webgpu', 'webgl2-nodes']) {
    test(`law and formulas on the device, ${renderer}`, async () => {
        const { call } = await studio.pageOf('three', renderer);
        for (const { name, cases: listed, header } of table.functions) {
            if (header.endsWith('/sight.h')) continue; // no shader calls it: tests/probes.test.mjs
            const cases = [...listed, ...(randomCases[name] ?? [])];
            const results = await call('evaluate', { ...signatureOf(name), cases: cases.map((c) => c.slice(0, -1)) });
            const worst = check(name, cases, results);
            console.log(`${renderer}, ${name}: ${cases.length} cases; the largest error is ${worst.toFixed(3)} of the tolerance`);
        }
    });
}
