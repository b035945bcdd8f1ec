// Bands 1 and 2 scaled down per colour channel by just so much that irradiance is negative on no normal. As
// withoutRinging() in include/halflight/render/probes.h (src/render/frame/probes_ringing.cpp gives the derivation).
import { shCosineLobe } from '../generated/shading.js';

const Y0 = 0.282094792, Y1 = 0.488602512, Y2A = 1.092548431, Y20 = 0.315391565, Y22 = 0.546274215;

/** @param {Float64Array} radiance nine RGB coefficients, changed in place */
export function removeRinging(radiance) {
    for (let channel = 0; channel < 3; ++channel) {
        const c = (i) => radiance[3 * i + channel] * shCosineLobe(i);
        const mean = Y0 * c(0);
        const b = [Y1 * c(3), Y1 * c(1), Y1 * c(2)];
        const xy = 0.5 * Y2A * c(4), yz = 0.5 * Y2A * c(5), xz = 0.5 * Y2A * c(7), zz = Y20 * c(6), xx = Y22 * c(8);
        const a = [[-zz + xx, xy, xz], [xy, -zz - xx, yz], [xz, yz, 2 * zz]];
        // No eigenvalue of a matrix without trace lies below -sqrt(2/3) of its norm.
        const norm = Math.hypot(...a.flat());
        if (mean - Math.hypot(...b) - 0.8165 * norm >= 0) continue;
        const least = minimumOnSphere(a, b);
        if (!(least < 0) || mean + least >= 0) continue;
        const window = (Math.max(mean, 0) / -least) * (1 - 1e-6);
        for (let i = 1; i < 9; ++i) radiance[3 * i + channel] *= window;
    }
}

/** A tight lower bound of n·A·n + b·n over unit vectors n (Moré and Sorensen 1983). */
function minimumOnSphere(a, b) {
    const { values, vectors } = eigenOf(a);
    const beta = [0, 1, 2].map((k) => b[0] * vectors[0][k] + b[1] * vectors[1][k] + b[2] * vectors[2][k]);
    const least = Math.min(...values);
    const length = Math.hypot(...b);
    let low = -least + 1e-10 * Math.max(length, Math.abs(least));
    let high = Math.max(low, -least + 0.5 * length);
    for (let i = 0; i < 50; ++i) {
        const middle = 0.5 * (low + high);
        const squared = beta.reduce((sum, x, k) => sum + (x / (values[k] + middle)) ** 2, 0);
        if (squared > 4) low = middle;
        else high = middle;
    }
    return -high - 0.25 * beta.reduce((sum, x, k) => sum + (x * x) / (values[k] + high), 0);
}

/** Eigenvalues of a symmetric matrix and its eigenvectors as columns (Jacobi 1846, cyclic rotations). */
function eigenOf(matrix) {
    const m = matrix.map((row) => [...row]);
    const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    for (let sweep = 0; sweep < 12; ++sweep) {
        for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
            if (m[p][q] === 0) continue;
            const theta = (0.5 * (m[q][q] - m[p][p])) / m[p][q];
            const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
            const c = 1 / Math.sqrt(t * t + 1);
            const s = t * c;
            for (let k = 0; k < 3; ++k) [m[k][p], m[k][q]] = [c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]];
            for (let k = 0; k < 3; ++k) [m[p][k], m[q][k]] = [c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]];
            for (let k = 0; k < 3; ++k) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
            m[p][q] = m[q][p] = 0;
        }
    }
    return { values: [m[0][0], m[1][1], m[2][2]], vectors: v };
}
