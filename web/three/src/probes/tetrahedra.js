// Delaunay tetrahedra of points on an integer lattice, for files that hold none. The same algorithm as
// src/scene/tetrahedra.cpp: incremental insertion (Bowyer 1981; Watson 1981) with exact predicates, and ties broken
// by a symbolic perturbation of the lifted heights (Devillers and Teillaud 2011), so both give the same cells.

const INFINITE = 0xffffffff;

/** Cells of four vertices and of the neighbours opposite each; neighbour 0xffffffff is the outside. */
export class Tetrahedra {
    /** @param {Int32Array} points three coordinates a point, 0…2^22, no two points alike */
    constructor(points) {
        this.points = points;
        /** @type {number[]} */
        this.vertices = [];
        /** @type {number[]} */
        this.neighbors = [];
        this.marks = [];
        this.round = 0;
        this.last = 0;
        this.free = [];
    }

    /** @returns {{vertices: Uint32Array, neighbors: Uint32Array} | null} null where all points lie in a plane */
    build() {
        const count = this.points.length / 3;
        const first = this.firstCell(count);
        if (!first) return null;
        for (let p = 0; p < count; ++p) if (!first.includes(p)) this.insert(p);
        return this.finite();
    }

    at(p, axis) {
        return this.points[3 * p + axis];
    }

    /** Six times the signed volume, its sign exact. */
    volume(a, b, c, d) {
        const at = (p, axis) => this.at(p, axis);
        const ux = at(b, 0) - at(a, 0), uy = at(b, 1) - at(a, 1), uz = at(b, 2) - at(a, 2);
        const vx = at(c, 0) - at(a, 0), vy = at(c, 1) - at(a, 1), vz = at(c, 2) - at(a, 2);
        const wx = at(d, 0) - at(a, 0), wy = at(d, 1) - at(a, 1), wz = at(d, 2) - at(a, 2);
        const nx = vy * wz - vz * wy, ny = vz * wx - vx * wz, nz = vx * wy - vy * wx; // exact: below 2^47
        const sum = ux * nx + uy * ny + uz * nz;
        const size = Math.abs(ux * nx) + Math.abs(uy * ny) + Math.abs(uz * nz);
        if (size < 2 ** 53 || Math.abs(sum) > size * 1e-14) return sum;
        return Number(BigInt(ux) * BigInt(nx) + BigInt(uy) * BigInt(ny) + BigInt(uz) * BigInt(nz));
    }

    /** Volume of cell `c` with its vertex `slot` replaced by p. */
    volumeWith(c, slot, p) {
        const v = (i) => (i === slot ? p : this.vertices[4 * c + i]);
        return this.volume(v(0), v(1), v(2), v(3));
    }

    distanceSquared(a, b) {
        let sum = 0;
        for (let axis = 0; axis < 3; ++axis) sum += (this.at(a, axis) - this.at(b, axis)) ** 2;
        return sum; // exact: below 2^47
    }

    /** Whether p is inside the sphere of finite cell c. */
    inSphere(c, p) {
        const volumes = [0, 1, 2, 3].map((i) => this.volumeWith(c, i, p));
        const squares = [0, 1, 2, 3].map((i) => this.distanceSquared(this.vertices[4 * c + i], p));
        let sum = 0;
        let size = 0;
        for (let i = 0; i < 4; ++i) {
            sum += volumes[i] * squares[i];
            size += Math.abs(volumes[i] * squares[i]);
        }
        if (size >= 2 ** 53 && Math.abs(sum) <= size * 1e-14) sum = Number(this.exactSum(c, p, squares));
        if (sum !== 0) return sum > 0;
        let highest = p;
        let inside = true;
        for (let i = 0; i < 4; ++i) {
            const vertex = this.vertices[4 * c + i];
            if (volumes[i] === 0 || vertex < highest) continue;
            highest = vertex;
            inside = volumes[i] < 0;
        }
        return inside;
    }

    exactSum(c, p, squares) {
        const big = (a, b, axis) => BigInt(this.at(a, axis) - this.at(b, axis));
        let sum = 0n;
        for (let slot = 0; slot < 4; ++slot) {
            const [a, b, d, e] = [0, 1, 2, 3].map((i) => (i === slot ? p : this.vertices[4 * c + i]));
            const [u, v, w] = [b, d, e].map((q) => [0, 1, 2].map((axis) => big(q, a, axis)));
            const volume =
                u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
            sum += volume * BigInt(squares[slot]);
        }
        return sum;
    }

    infiniteSlot(c) {
        for (let i = 0; i < 4; ++i) if (this.vertices[4 * c + i] === INFINITE) return i;
        return 4;
    }

    conflicts(c, p) {
        const slot = this.infiniteSlot(c);
        if (slot === 4) return this.inSphere(c, p);
        const side = this.volumeWith(c, slot, p);
        if (side !== 0) return side > 0;
        return this.inSphere(this.neighbors[4 * c + slot], p);
    }

    /** Visibility walk (Devillers, Pion and Teillaud 2002). */
    locate(p) {
        let current = this.last;
        const slot = this.infiniteSlot(current);
        if (slot < 4) current = this.neighbors[4 * current + slot];
        let from = INFINITE;
        for (;;) {
            let next = INFINITE;
            for (let i = 0; i < 4 && next === INFINITE; ++i) {
                const neighbor = this.neighbors[4 * current + i];
                if (neighbor !== from && this.volumeWith(current, i, p) < 0) next = neighbor;
            }
            if (next === INFINITE) return current;
            if (this.infiniteSlot(next) < 4) return next;
            from = current;
            current = next;
        }
    }

    /** The first cell and the four beyond its faces. Returns its vertices. */
    firstCell(count) {
        const pick = [0, 1];
        for (let c = 2; c < count && pick.length < 3; ++c) if (!this.collinear(0, 1, c)) pick.push(c);
        for (let d = 2; d < count && pick.length === 3; ++d) if (this.volume(0, 1, pick[2], d) !== 0) pick.push(d);
        if (pick.length < 4) return null;
        const v = this.volume(pick[0], pick[1], pick[2], pick[3]) > 0 ? pick : [pick[1], pick[0], pick[2], pick[3]];
        this.vertices.push(...v);
        this.neighbors.push(1, 2, 3, 4);
        for (let i = 0; i < 4; ++i) {
            const vertex = v.map((value, j) => (j === i ? INFINITE : value));
            const neighbor = [0, 1, 2, 3].map((j) => (j === i ? 0 : j + 1));
            const j = (i + 1) % 4;
            const k = (i + 2) % 4; // two vertices swapped: seen from outside, the face turns the other way
            [vertex[j], vertex[k]] = [vertex[k], vertex[j]];
            [neighbor[j], neighbor[k]] = [neighbor[k], neighbor[j]];
            this.vertices.push(...vertex);
            this.neighbors.push(...neighbor);
        }
        this.marks = new Array(5).fill(0);
        return v;
    }

    collinear(a, b, c) {
        const d = [0, 1, 2].map((axis) => [this.at(b, axis) - this.at(a, axis), this.at(c, axis) - this.at(a, axis)]);
        return [0, 1, 2].every((i) => d[i][0] * d[(i + 1) % 3][1] === d[(i + 1) % 3][0] * d[i][1]);
    }

    insert(p) {
        const stays = 2 * ++this.round;
        const goes = stays + 1;
        const conflict = [this.locate(p)];
        this.marks[conflict[0]] = goes;
        const boundary = [];
        for (let k = 0; k < conflict.length; ++k) {
            const current = conflict[k];
            for (let i = 0; i < 4; ++i) {
                const beyond = this.neighbors[4 * current + i];
                if (this.marks[beyond] < stays) {
                    this.marks[beyond] = this.conflicts(beyond, p) ? goes : stays;
                    if (this.marks[beyond] === goes) conflict.push(beyond);
                }
                if (this.marks[beyond] === goes) continue;
                const vertex = this.vertices.slice(4 * current, 4 * current + 4);
                vertex[i] = p;
                const beyondSlot = [0, 1, 2, 3].find((j) => this.neighbors[4 * beyond + j] === current);
                boundary.push({ vertex, slot: i, beyond, beyondSlot });
            }
        }
        for (const dead of conflict) this.vertices.fill(INFINITE, 4 * dead, 4 * dead + 4);
        this.free.push(...conflict.reverse());
        this.fillBall(p, boundary);
    }

    /** Joins p to every face of the ball, neighbours across the edges of those faces. */
    fillBall(p, boundary) {
        const edges = new Map();
        for (const face of boundary) {
            const id = this.free.length > 0 ? this.free.pop() : this.vertices.length / 4;
            for (let i = 0; i < 4; ++i) {
                this.vertices[4 * id + i] = face.vertex[i];
                this.neighbors[4 * id + i] = face.beyond;
            }
            this.neighbors[4 * face.beyond + face.beyondSlot] = id;
            this.marks[id] = 0;
            for (let j = 0; j < 4; ++j) {
                if (j === face.slot) continue;
                const ends = face.vertex.filter((_, i) => i !== j && i !== face.slot);
                const key = Math.min(...ends) * 2 ** 32 + Math.max(...ends);
                const other = edges.get(key);
                if (other === undefined) {
                    edges.set(key, 4 * id + j);
                    continue;
                }
                this.neighbors[4 * id + j] = other >>> 2;
                this.neighbors[other] = id;
            }
            this.last = id;
        }
    }

    finite() {
        const place = new Map();
        for (let c = 0; c < this.vertices.length / 4; ++c) if (this.infiniteSlot(c) === 4) place.set(c, place.size);
        const vertices = new Uint32Array(4 * place.size);
        const neighbors = new Uint32Array(4 * place.size);
        for (const [c, at] of place) {
            for (let i = 0; i < 4; ++i) {
                vertices[4 * at + i] = this.vertices[4 * c + i];
                neighbors[4 * at + i] = place.get(this.neighbors[4 * c + i]) ?? INFINITE;
            }
        }
        return { vertices, neighbors };
    }
}
