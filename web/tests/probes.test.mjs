// Interpolation between probes: against exact answers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import * as shading from '../three/src/generated/shading.js';
import { OUTSIDE, readCells } from '../three/src/probes/cells.js';
import { ProbeField, skyProbe } from '../three/src/probes/field.js';
import { removeRinging } from '../three/src/probes/ringing.js';
import { readSight } from '../three/src/probes/sight.js';
import { randomizer } from './random.mjs';

const { shIrradianceWeight } = shading;
const BLACK = { zenith: [0, 0, 0], horizon: [0, 0, 0], ground: [0, 0, 0] };

/** A cube of n x n x n probes, those between its faces moved by up to a seventh of their distance; six cells between each eight. */
function cube(n, side) {
    const random = randomizer(2);
    const positions = [];
    for (let i = 0; i < n ** 3; ++i)
        for (const k of [i % n, Math.floor(i / n) % n, Math.floor(i / n ** 2)])
            positions.push((side / (n - 1)) * (k + (k > 0 && k < n - 1 ? (random(2) - 1) / 7 : 0)));
    const vertices = [];
    const steps = [1, n, n * n];
    for (let i = 0; i < n ** 3; ++i) {
        if ([i % n, Math.floor(i / n) % n, Math.floor(i / n ** 2)].includes(n - 1)) continue;
        for (const [a, b, c] of [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]]) {
            const [v, w] = [i + steps[a], i + steps[a] + steps[b]];
            const end = w + steps[c];
            vertices.push(...((b - a + 3) % 3 === 1 ? [i, v, w, end] : [i, w, v, end]));
        }
    }
    return { positions, vertices };
}

const linear = (x, y, z) => 1 + x + 2 * y + 3 * z;

/** Probes with that light, and the cells between them. */
function probesOf(positions, value, vertices = null) {
    const count = positions.length / 3;
    const radiance = new Float32Array(27 * count);
    for (let i = 0; i < count; ++i) radiance[27 * i] = value(...positions.slice(3 * i, 3 * i + 3));
    const valid = new Uint8Array(count).fill(1);
    return { count, positions: Float64Array.from(positions), radiance, occlusion: new Float32Array(4 * count).fill(1), valid, grid: null, cells: vertices && readCells(vertices, null, valid) };
}

function cubeField(change = (probes) => probes) {
    const { positions, vertices } = cube(7, 10);
    return new ProbeField(change(probesOf(positions, linear, vertices)), BLACK);
}

test('linear fields are exact inside, and held at the nearest point outside', () => {
    const random = randomizer(2);
    const field = cubeField();
    assert.ok(field.cellsOfFile);
    for (let i = 0; i < 200; ++i) {
        const p = [random(14) - 2, random(14) - 2, random(14) - 2];
        const held = p.map((x) => Math.min(Math.max(x, 0), 10));
        assert.ok(Math.abs(field.sample(p).radiance[0] - linear(...held)) < 2e-4, `${p}`);
    }
});

test('without cells the nearest probe counts', () => {
    const plane = [0, 1, 0, 4, 1, 0, 0, 1, 4, 4, 1, 4];
    const field = new ProbeField(probesOf(plane, (x, y, z) => x + z), BLACK);
    assert.ok(!field.cellsOfFile);
    for (const [p, expected] of [[[1, 5, 1], 0], [[3, -5, 1], 4], [[2.1, 1, 2.1], 8]]) assert.equal(field.sample(p).radiance[0], expected);
    const hidden = probesOf(plane, (x, y, z) => x + z);
    hidden.valid[0] = 0;
    assert.equal(new ProbeField(hidden, BLACK).sample([0, 1, 0.1]).radiance[0], 4, 'probes inside geometry never count');
});

test('cells of a file: its own choice is kept, neighbours follow from corners', () => {
    const { cells } = cubeField().probes;
    // One cell alone, outside of which values are held.
    const few = { vertices: cells.vertices.slice(0, 4), neighbors: new Uint32Array(4).fill(OUTSIDE) };
    const one = cubeField((probes) => ({ ...probes, cells: readCells(few.vertices, few.neighbors, probes.valid) }));
    const far = one.sample([500, 500, 500]).radiance[0];
    const corners = [...few.vertices].map((v) => one.probes.radiance[27 * v]);
    assert.ok(far >= Math.min(...corners) - 1e-6 && far <= Math.max(...corners) + 1e-6);
    const inner = cells.neighbors.filter((n) => n !== OUTSIDE).length;
    assert.equal(cells.neighbors.length - inner, 6 * 6 * 6 * 2, 'two triangles of each square of the hull');
});

test('cells that do not fit: a sentence, or the nearest probe in their place', () => {
    const field = cubeField();
    const { valid, cells } = field.probes;
    const { vertices, neighbors } = cells;
    const changed = (list, i, value) => Object.assign(Uint32Array.from(list), { [i]: value });
    assert.throws(() => readCells(changed(vertices, 5, 999999), neighbors, valid), /probes: tetrahedron 1 has a vertex that is no valid probe/);
    assert.throws(() => readCells(vertices, neighbors, changed(valid, vertices[0], 0)), /no valid probe/);
    assert.throws(() => readCells(vertices, changed(neighbors, 9, 0xfffffff0), valid), /probes: tetrahedron 2 has a neighbour that is not beside it/);
    assert.throws(() => readCells(vertices, neighbors.slice(4), valid), /neighbors does not have/);
    const turned = cubeField((probes) => ({ ...probes, positions: probes.positions.map((x, i) => (i === 3 * vertices[0] ? x + 40 : x)) }));
    assert.ok(!turned.cellsOfFile, 'a probe moved through its cells');
    assert.equal(turned.sample([10, 10, 10]).radiance[0], linear(10, 10, 10));
});

/** Probes at x = -1 and 1 with light 0 and 1, each with a map of a wall at x = 0. As tests/render_plan/probe_sight_test.cpp. */
function walledField(withMaps) {
    const positions = [];
    for (const x of [-1, 1]) for (const y of [0, 1]) for (const z of [0, 1]) positions.push(x, y, z);
    const size = 9;
    const corners = [];
    for (let probe = 0; probe < 8; ++probe)
        for (let i = 0; i < size * size; ++i) {
            const [u, v] = [i % size, Math.floor(i / size)].map((k) => (2 * k) / (size - 1) - 1);
            const fold = Math.max(Math.abs(u) + Math.abs(v) - 1, 0);
            const across = u >= 0 ? u - fold : u + fold;
            corners.push(Math.round(65535 / Math.max((-across / positions[3 * probe]) * 4, 1)), 0);
        }
    const corner = [0, 4, 2, 1]; // steps of x, y, z in the list, which has z first
    const cells = [[1, 2, 3], [2, 3, 1], [3, 1, 2], [1, 3, 2], [3, 2, 1], [2, 1, 3]].map(([a, b, c]) => {
        const [v, w] = [corner[a], corner[a] + corner[b]];
        return (b - a + 3) % 3 === 1 ? [0, v, w, 7] : [0, w, v, 7];
    });
    const probes = probesOf(positions, (x) => (x < 0 ? 0 : 1), cells.flat());
    return new ProbeField({ ...probes, sight: withMaps ? readSight(new Array(8).fill(4), corners) : null }, BLACK);
}

test('probes that see a wall light nothing behind it', () => {
    const random = randomizer(4);
    const seeing = walledField(true);
    for (let i = 0; i < 500; ++i) {
        const p = [0.02 + random(0.98), random(1), random(1)];
        assert.ok(seeing.sample(p).radiance[0] > 0.99, `${p}`);
        assert.ok(seeing.sample([-p[0], p[1], p[2]]).radiance[0] < 0.01, `${p}`);
    }
    assert.ok(Math.abs(walledField(false).sample([0.02, 0.5, 0.5]).radiance[0] - 0.51) < 0.01, 'without maps half of it comes through');
    assert.throws(() => readSight([1, 0, 2], [1, 2, 3, 4]), /square map/);
});

test('formulas of sight.h give what the conformance table says', () => {
    const table = JSON.parse(readFileSync(new URL('../../assets/conformance/law.json', import.meta.url), 'utf8'));
    const functions = table.functions.filter((f) => f.header.endsWith('/sight.h'));
    assert.equal(functions.length, 4);
    for (const { name, cases } of functions)
        for (const list of cases) {
            const result = shading[name](...list.slice(0, -1).map((x) => (Array.isArray(x) ? { x: x[0], y: x[1], z: x[2] } : x)));
            assert.ok(Math.abs(result - list.at(-1)) <= 1e-4 * Math.abs(list.at(-1)) + 1e-5, `${name}(${list})`);
        }
});

const irradiance = (radiance, n) => {
    let sum = 0;
    for (let i = 0; i < 9; ++i) sum += radiance[3 * i] * shIrradianceWeight(i, n);
    return sum;
};

test('light without ringing is negative on no normal, and keeps its mean', () => {
    const random = randomizer(3);
    const radiance = new Float64Array(27);
    for (let i = 0; i < 9; ++i) radiance.fill(shIrradianceWeight(i, { x: 0, y: 0.6, z: 0.8 }) * (i === 0 ? 1 : 3), 3 * i, 3 * i + 3);
    const before = radiance[0];
    let least = Infinity;
    const normals = Array.from({ length: 2000 }, () => {
        const v = [random(2) - 1, random(2) - 1, random(2) - 1];
        const length = Math.hypot(...v);
        return { x: v[0] / length, y: v[1] / length, z: v[2] / length };
    });
    assert.ok(Math.min(...normals.map((n) => irradiance(radiance, n))) < 0, 'it rings before');
    removeRinging(radiance);
    for (const n of normals) least = Math.min(least, irradiance(radiance, n));
    assert.ok(least > -1e-9 && least < 0.05 * radiance[0]);
    assert.equal(radiance[0], before);
});

test('the sky as a probe lights a level surface by its own integral', () => {
    // Over a hemisphere: integral of (h + (z - h) cos) cos = pi h + 2 pi / 3 (z - h).
    const sky = skyProbe({ zenith: [2, 2, 2], horizon: [1, 1, 1], ground: [0.5, 0.5, 0.5] });
    const exact = Math.PI + (2 * Math.PI) / 3;
    assert.ok(Math.abs(irradiance(sky.radiance, { x: 0, y: 1, z: 0 }) / exact - 1) < 0.02);
});
