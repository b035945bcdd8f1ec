// How far probes see, and which points they do not: docs/format.md, "Sight". As src/render/frame/probes_sight.cpp.
import { invalid } from '../file/check.js';
import { octahedralShare, octahedralX, octahedralY, probeSight } from '../generated/shading.js';

const ONE = 65535;

/** @typedef {{size: number, ranges: Float32Array, first: Int32Array, nearness: Float32Array, variance: Float32Array}} Sight */

/** @param {ArrayLike<number> | null} ranges by probe @param {ArrayLike<number> | null} corners two for each @returns {Sight | null} */
export function readSight(ranges, corners) {
    if (!ranges || !corners) return null;
    let maps = 0;
    const first = Int32Array.from(ranges, (range) => (range > 0 ? maps++ : -1));
    const count = corners.length / 2;
    const size = Math.round(Math.sqrt(count / maps));
    if (!(size >= 3) || size % 2 === 0 || maps * size * size !== count)
        throw invalid('/extensions/HALFLIGHT_mixed_lighting/probes', 'sight does not hold a square map for each sightRange above 0');
    const nearness = Float32Array.from({ length: count }, (_, i) => ONE / Math.max(corners[2 * i], 1));
    const variance = nearness.map((n, i) => ((n * corners[2 * i + 1]) / ONE) ** 2);
    return { size, ranges: Float32Array.from(ranges), first: first.map((map) => map * size * size), nearness, variance };
}

/** Weight of a probe at a point this far from it: 1 in sight, nearly 0 behind a surface. @param {Sight | null | undefined} sight @param {number} probe @param {number} dx offset of the point @param {number} dy @param {number} dz */
export function sightWeight(sight, probe, dx, dy, dz) {
    if (!sight || !(sight.ranges[probe] > 0)) return 1;
    const meters = Math.abs(dx) + Math.abs(dy) + Math.abs(dz);
    if (!(meters > 0)) return 1;
    const d = { x: dx, y: dy, z: dz };
    const cells = sight.size - 1;
    const u = (octahedralX(d) * 0.5 + 0.5) * cells;
    const v = (octahedralY(d) * 0.5 + 0.5) * cells;
    const x = Math.min(Math.max(Math.floor(u), 0), cells - 1);
    const y = Math.min(Math.max(Math.floor(v), 0), cells - 1);
    const mirrored = 2 * x < cells !== 2 * y < cells;
    let nearness = 0;
    let variance = 0;
    for (let corner = 0; corner < 4; ++corner) {
        const column = corner & 1;
        const row = corner >> 1;
        const share = octahedralShare(column, row, u - x, v - y, mirrored);
        const at = sight.first[probe] + (y + row) * sight.size + x + column;
        nearness += share * sight.nearness[at];
        variance += share * sight.variance[at];
    }
    return probeSight(nearness, variance, Math.max(sight.ranges[probe] / meters, 1));
}
