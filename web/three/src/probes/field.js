// Light and occlusion at a point, interpolated between the bake's probes: linear in each Delaunay tetrahedron (Cupisz
// 2012); outside their convex hull the value at the hull's nearest point. As ProbeInterpolator in
// include/halflight/render/probes.h.
import { shBasis, shIrradianceWeight } from '../generated/shading.js';
import { skyCoefficients } from '../scene/sky_picture.js';
import { cellsFit, OUTSIDE } from './cells.js';
import { nearestOnTriangle } from './nearest.js';
import { removeRinging } from './ringing.js';
import { sightWeight } from './sight.js';
import { Tetrahedra } from './tetrahedra.js';

const LATTICE = 2 ** 22;
const FLAT = 1e-5;

/** @typedef {{radiance: Float64Array, occlusion: Float64Array}} ProbeSample nine RGB coefficients, four channels */

/** The open sky as a probe meets it; nothing occluded. @returns {ProbeSample} */
export function skyProbe(sky) {
    if (sky.picture) return { radiance: skyCoefficients(sky.picture), occlusion: Float64Array.of(1, 1, 1, 1) };
    const up = { x: 0, y: 1, z: 0 };
    const down = { x: 0, y: -1, z: 0 };
    const radiance = new Float64Array(27);
    for (let c = 0; c < 3; ++c) {
        radiance[c] = sky.horizon[c] * 4 * Math.PI * shBasis(0, up);
        for (let i = 0; i < 9; ++i) {
            radiance[3 * i + c] += (sky.zenith[c] - sky.horizon[c]) * shIrradianceWeight(i, up);
            radiance[3 * i + c] += (sky.ground[c] - sky.horizon[c]) * shIrradianceWeight(i, down);
        }
    }
    return { radiance, occlusion: Float64Array.of(1, 1, 1, 1) };
}

export class ProbeField {
    /** @param {import('../file/read.js').ProbeData | null} probes @param {any} sky */
    constructor(probes, sky) {
        this.sky = skyProbe(sky);
        this.probes = probes;
        this.spacing = [Infinity, Infinity, Infinity];
        /** @type {number[]} probe of each vertex */
        this.sources = [];
        this.last = 0;
        this.hull = [];
        /** Whether the cells are those of the file. */
        this.cellsOfFile = false;
        if (!probes) return;
        for (let i = 0; i < probes.count; ++i) if (probes.valid[i]) this.sources.push(i);
        if (this.sources.length > 0) this.build();
    }

    get empty() {
        return this.sources.length === 0;
    }

    build() {
        const { low, size } = this.bounds();
        const extent = Math.max(...size);
        const flat = size.map((s) => !(s > (this.probes.grid ? 0 : FLAT * extent)));
        this.spacing = this.meanSpacing(size, flat);
        if (this.probes.cells && cellsFit(this.probes.cells, this.probes.positions)) {
            this.cellsOfFile = true;
            this.cells = this.probes.cells;
            this.positions = this.probes.positions;
            this.sources = Array.from({ length: this.probes.count }, (_, i) => i);
        } else {
            this.triangulate(low, size, flat);
        }
        this.findHull();
    }

    /** For files of version 1 of the format, and for probes in one plane. */
    triangulate(low, size, flat) {
        const extent = Math.max(...size);
        const scale = this.latticeScale(extent);
        const points = this.latticePoints(low, scale, flat);
        // Along an axis without extent every probe gets a copy one layer up, so that there are tetrahedra.
        const candidates = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [0, 1, 2].filter((axis) => bits >> axis & 1 || flat[axis]));
        for (const axes of candidates) {
            const layered = this.withLayers(points, axes);
            const cells = new Tetrahedra(Int32Array.from(layered.points)).build();
            if (!cells) continue;
            this.sources = layered.sources;
            this.cells = cells;
            const step = (axis) => (flat[axis] ? 1 : scale[axis]);
            this.positions = Float64Array.from(layered.points, (x, i) => low[i % 3] + x * step(i % 3));
            break;
        }
    }

    bounds() {
        const low = [Infinity, Infinity, Infinity];
        const high = [-Infinity, -Infinity, -Infinity];
        for (const source of this.sources) {
            for (let axis = 0; axis < 3; ++axis) {
                const x = this.probes.positions[3 * source + axis];
                low[axis] = Math.min(low[axis], x);
                high[axis] = Math.max(high[axis], x);
            }
        }
        return { low, size: high.map((x, axis) => x - low[axis]) };
    }

    meanSpacing(size, flat) {
        const grid = this.probes.grid;
        if (grid) return grid.spacing.map((s, axis) => (grid.size[axis] > 1 ? s : Infinity));
        const extended = size.filter((_, axis) => !flat[axis]);
        if (extended.length === 0) return [Infinity, Infinity, Infinity];
        const perAxis = Math.max(this.sources.length ** (1 / extended.length) - 1, 1);
        const spacing = extended.reduce((a, b) => a * b, 1) ** (1 / extended.length) / perAxis;
        return flat.map((f) => (f ? Infinity : spacing));
    }

    latticeScale(extent) {
        const grid = this.probes.grid;
        if (grid) return grid.spacing.map((s) => (s > 0 ? s : 1));
        return new Array(3).fill(extent > 0 ? extent / LATTICE : 1);
    }

    latticePoints(low, scale, flat) {
        const points = [];
        const sources = [];
        const seen = new Set();
        for (const source of this.sources) {
            const p = [0, 1, 2].map((axis) =>
                flat[axis] ? 0 : Math.round((this.probes.positions[3 * source + axis] - low[axis]) / scale[axis])
            );
            if (seen.has(p.join())) continue; // of probes at one place the first counts
            seen.add(p.join());
            points.push(...p);
            sources.push(source);
        }
        return { points, sources };
    }

    withLayers({ points, sources }, axes) {
        const layer = this.probes.grid ? 1 : Math.max(1, Math.floor(LATTICE / Math.ceil(Math.sqrt(sources.length))));
        let result = { points, sources };
        for (const axis of axes) {
            const copy = result.points.map((x, i) => (i % 3 === axis ? x + layer : x));
            result = { points: [...result.points, ...copy], sources: [...result.sources, ...result.sources] };
        }
        return result;
    }

    findHull() {
        const { vertices, neighbors } = this.cells;
        for (let i = 0; i < neighbors.length; ++i) {
            if (neighbors[i] !== OUTSIDE) continue;
            const cell = i >> 2;
            this.hull.push([0, 1, 2, 3].filter((j) => j !== i % 4).map((j) => vertices[4 * cell + j]));
        }
    }

    /** Barycentric coordinates of a point in cell c. */
    barycentric(c, p) {
        const v = [0, 1, 2, 3].map((i) => {
            const at = 3 * this.cells.vertices[4 * c + i];
            return [this.positions[at] - p[0], this.positions[at + 1] - p[1], this.positions[at + 2] - p[2]];
        });
        const w = [volume(v[1], v[3], v[2]), volume(v[0], v[2], v[3]), volume(v[0], v[3], v[1]), volume(v[0], v[1], v[2])];
        const sum = w[0] + w[1] + w[2] + w[3];
        return w.map((x) => x / sum);
    }

    /** Four probes around a point and their shares. @param {number[]} p @returns {{probes: number[], weights: number[]}} */
    weights(p) {
        let current = this.last;
        let from = OUTSIDE;
        for (let steps = 0; steps < this.cells.vertices.length; ++steps) {
            const w = this.barycentric(current, p);
            let worst = -1;
            for (let i = 0; i < 4; ++i) {
                const neighbor = this.cells.neighbors[4 * current + i];
                if (w[i] < -1e-9 && neighbor !== from && (worst < 0 || w[i] < w[worst])) worst = i;
            }
            if (worst < 0) {
                this.last = current;
                const vertices = Array.from(this.cells.vertices.slice(4 * current, 4 * current + 4));
                return { probes: vertices.map((v) => this.sources[v]), weights: w.map((x) => Math.max(x, 0)) };
            }
            const next = this.cells.neighbors[4 * current + worst];
            if (next === OUTSIDE) break;
            from = current;
            current = next;
        }
        return this.hullWeights(p);
    }

    hullWeights(p) {
        let best = { distance: Infinity, probes: [0], weights: [1] };
        for (const face of this.hull) {
            const v = face.map((i) => [0, 1, 2].map((axis) => this.positions[3 * i + axis] - p[axis]));
            const w = nearestOnTriangle(v[0], v[1], v[2]);
            let distance = 0;
            for (let axis = 0; axis < 3; ++axis) distance += (w[0] * v[0][axis] + w[1] * v[1][axis] + w[2] * v[2][axis]) ** 2;
            if (distance < best.distance) best = { distance, probes: face.map((i) => this.sources[i]), weights: w };
        }
        return best;
    }

    /** Shares of probes, each times how well its probe sees the point that the shares are those of. */
    seen(probes, shares) {
        const { positions, sight } = this.probes;
        if (!sight) return shares;
        const sum = shares.reduce((a, b) => a + b, 0);
        const point = [0, 1, 2].map((axis) => shares.reduce((at, share, k) => at + (share / sum) * positions[3 * probes[k] + axis], 0));
        return shares.map((share, k) =>
            share > 0 ? share * sightWeight(sight, probes[k], point.map((x, axis) => x - positions[3 * probes[k] + axis])) : 0
        );
    }

    /** @param {number[]} p world @returns {ProbeSample} */
    sample(p) {
        const sum = { radiance: new Float64Array(27), occlusion: new Float64Array(4) };
        if (this.empty) {
            sum.radiance.set(this.sky.radiance);
            sum.occlusion.set(this.sky.occlusion);
        } else {
            const { probes, weights: shares } = this.weights(p);
            const weights = this.seen(probes, shares);
            const total = weights.reduce((a, b) => a + b, 0);
            probes.forEach((probe, k) => {
                const w = weights[k] / total;
                for (let i = 0; i < 27; ++i) sum.radiance[i] += w * this.probes.radiance[27 * probe + i];
                for (let c = 0; c < 4; ++c) sum.occlusion[c] += w * this.probes.occlusion[4 * probe + c];
            });
        }
        removeRinging(sum.radiance); // after interpolation: the sum may ring less than each probe
        return sum;
    }
}

function volume(a, b, c) {
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    );
}
