// Which probes light a point, and by what shares: a walk through the tetrahedra from where the last one ended; outside of
// them the nearest triangle of their hull. It runs for each object that moves in each frame, so it makes no objects.
import { OUTSIDE } from './cells.js';
import { nearestOnTriangle } from './nearest.js';

/** What a search found, and where the next one for the same object begins. */
export class Place {
    constructor() {
        this.cell = 0;
        /** Four in a cell, three on the hull, one without cells. */
        this.count = 0;
        this.probes = new Int32Array(4);
        this.weights = new Float64Array(4);
    }
}

/** Six times the volume of a tetrahedron whose fourth vertex is the origin; v holds vertices of three numbers. */
function volume(v, i, j, k) {
    const a = 3 * i, b = 3 * j, c = 3 * k;
    return v[a] * (v[b + 1] * v[c + 2] - v[b + 2] * v[c + 1]) + v[a + 1] * (v[b + 2] * v[c] - v[b] * v[c + 2]) + v[a + 2] * (v[b] * v[c + 1] - v[b + 1] * v[c]);
}

export class CellSearch {
    /** @param {import('./cells.js').Cells} cells @param {ArrayLike<number>} positions of probes */
    constructor(cells, positions) {
        this.cells = cells;
        this.positions = positions;
        this.shares = new Float64Array(4);
        this.around = new Float64Array(12);
        this.findHull();
    }

    /** Triangles of the hull, a sphere around each, and the triangle of each outer face. */
    findHull() {
        const { vertices, neighbors } = this.cells;
        const triangles = [];
        const spheres = [];
        this.hullOf = new Int32Array(neighbors.length).fill(-1);
        for (let i = 0; i < neighbors.length; ++i) {
            if (neighbors[i] !== OUTSIDE) continue;
            this.hullOf[i] = triangles.length / 3;
            const face = [0, 1, 2, 3].filter((j) => j !== i % 4).map((j) => vertices[4 * (i >> 2) + j]);
            triangles.push(...face);
            const at = (axis) => face.map((vertex) => this.positions[3 * vertex + axis]);
            const center = [0, 1, 2].map((axis) => at(axis).reduce((sum, x) => sum + x, 0) / 3);
            const radius = Math.sqrt(Math.max(...[0, 1, 2].map((k) => center.reduce((sum, x, axis) => sum + (at(axis)[k] - x) ** 2, 0))));
            spheres.push(...center, radius);
        }
        this.triangles = Int32Array.from(triangles);
        this.spheres = Float64Array.from(spheres);
    }

    /** Barycentric coordinates of a point in cell c, in `shares`. */
    barycentric(c, p) {
        const { positions, shares: w, around: v } = this;
        const { vertices } = this.cells;
        for (let i = 0; i < 4; ++i) {
            const at = 3 * vertices[4 * c + i];
            for (let axis = 0; axis < 3; ++axis) v[3 * i + axis] = positions[at + axis] - p[axis];
        }
        w[0] = volume(v, 1, 3, 2);
        w[1] = volume(v, 0, 2, 3);
        w[2] = volume(v, 0, 3, 1);
        w[3] = volume(v, 0, 1, 2);
        const sum = w[0] + w[1] + w[2] + w[3];
        for (let i = 0; i < 4; ++i) w[i] /= sum;
    }

    /** @param {ArrayLike<number>} p @param {Place} place of the last search, and of this one */
    find(p, place) {
        const { vertices, neighbors } = this.cells;
        const w = this.shares;
        let current = place.cell;
        let from = -1;
        let face = -1;
        for (let steps = 0; steps < vertices.length; ++steps) {
            this.barycentric(current, p);
            let worst = -1;
            for (let i = 0; i < 4; ++i)
                if (w[i] < -1e-9 && neighbors[4 * current + i] !== from && (worst < 0 || w[i] < w[worst])) worst = i;
            if (worst < 0) {
                place.cell = current;
                place.count = 4;
                for (let i = 0; i < 4; ++i) {
                    place.probes[i] = vertices[4 * current + i];
                    place.weights[i] = Math.max(w[i], 0);
                }
                return;
            }
            const next = neighbors[4 * current + worst];
            if (next === OUTSIDE) {
                face = this.hullOf[4 * current + worst];
                break;
            }
            from = current;
            current = next;
        }
        place.cell = current;
        this.findOnHull(p, place, Math.max(face, 0));
    }

    /** Exhaustive, but for triangles whose sphere is farther than what is found. @param {number} first triangle that is near */
    findOnHull(p, place, first) {
        const { spheres, triangles } = this;
        place.count = 1; // where a point is not finite
        place.probes[0] = this.triangles[0];
        place.weights[0] = 1;
        let best = Infinity;
        for (let k = -1; k < triangles.length / 3; ++k) {
            const face = k < 0 ? first : k;
            if (k >= 0) {
                const x = spheres[4 * k] - p[0], y = spheres[4 * k + 1] - p[1], z = spheres[4 * k + 2] - p[2];
                const reach = best + spheres[4 * k + 3];
                if (k === first || x * x + y * y + z * z >= reach * reach) continue;
            }
            best = this.tryTriangle(p, place, face, best);
        }
    }

    /** Distance of a triangle where that is less than `best`, and its shares; else `best`. */
    tryTriangle(p, place, face, best) {
        const { positions, shares: w, around: v } = this;
        for (let i = 0; i < 3; ++i) {
            const at = 3 * this.triangles[3 * face + i];
            for (let axis = 0; axis < 3; ++axis) v[3 * i + axis] = positions[at + axis] - p[axis];
        }
        nearestOnTriangle(v, w);
        let squared = 0;
        for (let axis = 0; axis < 3; ++axis) squared += (w[0] * v[axis] + w[1] * v[3 + axis] + w[2] * v[6 + axis]) ** 2;
        const distance = Math.sqrt(squared);
        if (!(distance < best)) return best;
        place.count = 3;
        for (let i = 0; i < 3; ++i) {
            place.probes[i] = this.triangles[3 * face + i];
            place.weights[i] = w[i];
        }
        return distance;
    }
}

/** The search for files without cells. */
export class NearestProbe {
    /** @param {number[]} sources valid probes @param {ArrayLike<number>} positions of all */
    constructor(sources, positions) {
        this.sources = sources;
        this.positions = positions;
    }

    /** @param {ArrayLike<number>} p @param {Place} place */
    find(p, place) {
        let best = Infinity;
        place.count = 1;
        place.weights[0] = 1;
        place.probes[0] = this.sources[0];
        for (const source of this.sources) {
            const x = this.positions[3 * source] - p[0], y = this.positions[3 * source + 1] - p[1], z = this.positions[3 * source + 2] - p[2];
            const squared = x * x + y * y + z * z;
            if (squared >= best) continue;
            best = squared;
            place.probes[0] = source;
        }
    }
}
