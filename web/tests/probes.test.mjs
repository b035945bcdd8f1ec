// Interpolation between probes: against exact answers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import * as shading from '../three/src/generated/shading.js';
import { OUTSIDE, readCells } from '../three/src/probes/cells.js';
import { ProbeField, skyProbe } from '../three/src/probes/field.js';
import { removeRinging } from '../three/src/probes/ringing.js';
import { readSight } from '../three/src/probes/sight.js';
import { Tetrahedra } from '../three/src/probes/tetrahedra.js';
import { randomizer } from './random.mjs';

const { shIrradianceWeight } = shading;
const BLACK = { zenith: [0, 0, 0], horizon: [0, 0, 0], ground: [0, 0, 0] };

function volumeOf(points) {
    const mesh = new Tetrahedra(Int32Array.from(points));
    const cells = mesh.build();
    let sum = 0;
    for (let c = 0; c < cells.vertices.length / 4; ++c) {
        const v = mesh.volume(...cells.vertices.slice(4 * c, 4 * c + 4));
        assert.ok(v > 0, 'no cell is flat or turned over');
        sum += v / 6;
    }
    return sum;
}

test('tetrahedra fill a grid, where every sphere test is a tie', () => {
    const points = [];
    for (let x = 0; x < 6; ++x) for (let y = 0; y < 5; ++y) for (let z = 0; z < 4; ++z) points.push(x, y, z);
    assert.ok(Math.abs(volumeOf(points) - 5 * 4 * 3) < 1e-9);
});

test('tetrahedra fill the hull of random points', () => {
    const random = randomizer(1);
    const side = 2 ** 22;
    const points = [];
    for (let i = 0; i < 8; ++i) points.push(i & 1 ? side : 0, i & 2 ? side : 0, i & 4 ? side : 0);
    for (let i = 0; i < 900; ++i) points.push(Math.floor(random(side)));
    assert.ok(Math.abs(volumeOf(points) / side ** 3 - 1) < 1e-9);
});

function fieldOf(positions, value) {
    const count = positions.length / 3;
    const radiance = new Float32Array(27 * count);
    for (let i = 0; i < count; ++i) radiance[27 * i] = value(...positions.slice(3 * i, 3 * i + 3));
    const probes = { count, positions: Float32Array.from(positions), radiance, occlusion: new Float32Array(4 * count).fill(1), valid: new Uint8Array(count).fill(1), grid: null, cells: null };
    return new ProbeField(probes, BLACK);
}

test('linear fields are exact inside, and held at the nearest point outside', () => {
    const random = randomizer(2);
    const positions = [0, 0, 0, 10, 0, 0, 0, 10, 0, 0, 0, 10, 10, 10, 0, 10, 0, 10, 0, 10, 10, 10, 10, 10];
    for (let i = 0; i < 600; ++i) positions.push(random(10));
    const linear = (x, y, z) => 1 + x + 2 * y + 3 * z;
    const field = fieldOf(positions, linear);
    for (let i = 0; i < 200; ++i) {
        const p = [random(14) - 2, random(14) - 2, random(14) - 2];
        const held = p.map((x) => Math.min(Math.max(x, 0), 10));
        assert.ok(Math.abs(field.sample(p).radiance[0] - linear(...held)) < 2e-4, `${p}`);
    }
});

test('probes in a plane, on a line, at one place', () => {
    const plane = fieldOf([0, 1, 0, 4, 1, 0, 0, 1, 4, 4, 1, 4], (x, y, z) => x + z);
    assert.ok(Math.abs(plane.sample([1, 5, 2]).radiance[0] - 3) < 1e-5);
    const line = fieldOf([0, 0, 0, 0, 2, 0, 0, 4, 0], (x, y) => y);
    assert.ok(Math.abs(line.sample([3, 1, 0]).radiance[0] - 1) < 1e-5);
    assert.ok(Math.abs(fieldOf([1, 2, 3], () => 7).sample([9, 9, 9]).radiance[0] - 7) < 1e-5);
});

/** A field that has its cells, as a file brings them. */
function fileField(change = (probes) => probes) {
    const random = randomizer(5);
    const positions = [];
    for (let i = 0; i < 900; ++i) positions.push(Math.round(random(4000)) / 400);
    const made = fieldOf(positions, (x, y, z) => 1 + x + 2 * y + 3 * z);
    const { vertices, neighbors } = made.cells;
    const sources = vertices.map((v) => made.sources[v]);
    return { made, vertices: sources, neighbors, field: new ProbeField(change({ ...made.probes, cells: readCells(sources, neighbors, made.probes.valid) }), BLACK) };
}

test('the cells of the file are those that are interpolated in', () => {
    const { field, vertices, neighbors } = fileField();
    assert.ok(field.cellsOfFile);
    assert.deepEqual([...field.cells.vertices], [...vertices]);
    assert.deepEqual([...readCells(vertices, null, field.probes.valid).neighbors], [...neighbors], 'neighbours follow from the tetrahedra');
    const random = randomizer(6);
    for (let i = 0; i < 200; ++i) {
        const p = [1, 1, 1].map(() => 3 + random(4));
        assert.ok(Math.abs(field.sample(p).radiance[0] - (1 + p[0] + 2 * p[1] + 3 * p[2])) < 1e-4, `${p}`);
    }
    // A file's own choice of cells is kept: here one cell alone, outside of which values are held.
    const one = fileField((probes) => ({ ...probes, cells: readCells(vertices.slice(0, 4), new Array(4).fill(OUTSIDE), probes.valid) })).field;
    const far = one.sample([500, 500, 500]).radiance[0];
    const corners = [...vertices.slice(0, 4)].map((v) => one.probes.radiance[27 * v]);
    assert.ok(far >= Math.min(...corners) - 1e-6 && far <= Math.max(...corners) + 1e-6);
});

test('cells that do not fit: a sentence, or others in their place', () => {
    const { field, vertices, neighbors } = fileField();
    const { valid } = field.probes;
    const changed = (list, i, value) => Object.assign(Uint32Array.from(list), { [i]: value });
    assert.throws(() => readCells(changed(vertices, 5, 999999), neighbors, valid), /probes: tetrahedron 1 has a vertex that is no valid probe/);
    assert.throws(() => readCells(vertices, neighbors, changed(valid, vertices[0], 0)), /no valid probe/);
    assert.throws(() => readCells(vertices, changed(neighbors, 9, 0xfffffff0), valid), /probes: tetrahedron 2 has a neighbour that is not beside it/);
    assert.throws(() => readCells(vertices, neighbors.slice(4), valid), /neighbors does not have/);
    const turned = fileField((probes) => ({ ...probes, positions: probes.positions.map((x, i) => (i === 3 * vertices[0] ? x + 40 : x)) })).field;
    assert.ok(!turned.cellsOfFile, 'a probe moved through its cells');
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
    const { probes } = fieldOf(positions, (x) => (x < 0 ? 0 : 1));
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
