// The tetrahedra between probes that a file holds, checked: docs/format.md, "Probes".
import { invalid } from '../file/check.js';

const PROBES = '/extensions/HALFLIGHT_mixed_lighting/probes';

export const OUTSIDE = 0xffffffff;

/** @typedef {{vertices: Uint32Array, neighbors: Uint32Array}} Cells four indices of probes and of cells for each */

/**
 * @param {ArrayLike<number>} tetrahedra @param {ArrayLike<number> | null} neighbors @param {ArrayLike<number>} valid by probe
 * @returns {Cells}
 */
export function readCells(tetrahedra, neighbors, valid) {
    const vertices = Uint32Array.from(tetrahedra);
    if (vertices.length % 4 !== 0) throw invalid(PROBES, 'tetrahedra is not a list of four indices each');
    for (let i = 0; i < vertices.length; ++i)
        if (!valid[vertices[i]]) throw invalid(PROBES, `tetrahedron ${i >> 2} has a vertex that is no valid probe`);
    if (!neighbors) return { vertices, neighbors: findNeighbors(vertices) };
    const cells = { vertices, neighbors: Uint32Array.from(neighbors) };
    if (neighbors.length !== vertices.length)
        throw invalid(PROBES, `neighbors does not have ${vertices.length / 4} elements`);
    for (let i = 0; i < vertices.length; ++i)
        if (!meets(cells, i)) throw invalid(PROBES, `tetrahedron ${i >> 2} has a neighbour that is not beside it`);
    return cells;
}

/** Whether the cell beyond face `i` has that face's three vertices and names the cell back. */
function meets({ vertices, neighbors }, i) {
    const cell = i >> 2;
    const beyond = neighbors[i];
    if (beyond === OUTSIDE) return true;
    if (beyond === cell || beyond >= neighbors.length / 4) return false;
    const back = neighbors.indexOf(cell, 4 * beyond);
    if (back < 0 || back >= 4 * beyond + 4) return false;
    for (let k = 4 * cell; k < 4 * cell + 4; ++k) {
        if (k === i) continue;
        const same = vertices.indexOf(vertices[k], 4 * beyond);
        if (same < 0 || same >= 4 * beyond + 4 || same === back) return false;
    }
    return true;
}

/** Cells with three vertices in common are neighbours. */
function findNeighbors(vertices) {
    const neighbors = new Uint32Array(vertices.length).fill(OUTSIDE);
    const faces = new Map();
    for (let i = 0; i < vertices.length; ++i) {
        const cell = i >> 2;
        const face = [0, 1, 2, 3].filter((k) => k !== i % 4).map((k) => vertices[4 * cell + k]);
        const key = face.sort((a, b) => a - b).join();
        const other = faces.get(key);
        faces.set(key, i);
        if (other === undefined) continue;
        neighbors[i] = other >> 2;
        neighbors[other] = cell;
    }
    return neighbors;
}

/** Whether every cell has a volume above 0: an edit of positions may turn some inside out. */
export function cellsFit({ vertices }, positions) {
    const at = (vertex, axis) => positions[3 * vertex + axis];
    for (let c = 0; c < vertices.length; c += 4) {
        const [a, b, d, e] = vertices.subarray(c, c + 4);
        const [u, v, w] = [b, d, e].map((vertex) => [0, 1, 2].map((axis) => at(vertex, axis) - at(a, axis)));
        const volume =
            u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
        if (!(volume > 0)) return false;
    }
    return vertices.length > 0;
}
