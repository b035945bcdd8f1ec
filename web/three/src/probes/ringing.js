// Bands 1 and 2 scaled down per colour channel by just so much that irradiance is negative on no normal. As
// withoutRinging() in include/halflight/render/probes.h (src/render/frame/probes_ringing.cpp gives the derivation).
import { shCosineLobe } from '../generated/shading.js';

const Y0 = 0.282094792, Y1 = 0.488602512, Y2A = 1.092548431, Y20 = 0.315391565, Y22 = 0.546274215;

const LOBES = Float64Array.from({ length: 9 }, (_, i) => shCosineLobe(i));
/** Off-diagonal numbers, relative to a matrix's norm, from which on it counts as diagonal. */
const DIAGONAL = 1e-17;
const c = new Float64Array(9);
const a = new Float64Array(9);
const b = new Float64Array(3);
const v = new Float64Array(9);

/** @param {Float64Array} radiance nine RGB coefficients, changed in place */
export function removeRinging(radiance) {
    for (let channel = 0; channel < 3; ++channel) {
        for (let i = 0; i < 9; ++i) c[i] = radiance[3 * i + channel] * LOBES[i];
        const mean = Y0 * c[0];
        const length = Y1 * Math.sqrt(c[1] * c[1] + c[2] * c[2] + c[3] * c[3]);
        const xy = 0.5 * Y2A * c[4], yz = 0.5 * Y2A * c[5], xz = 0.5 * Y2A * c[7], zz = Y20 * c[6], xx = Y22 * c[8];
        const squares = (xx - zz) * (xx - zz) + (xx + zz) * (xx + zz) + 4 * zz * zz;
        // No eigenvalue of a matrix without trace lies below -sqrt(2/3) of its norm.
        const norm = Math.sqrt(squares + 2 * (xy * xy + yz * yz + xz * xz));
        if (mean - length - 0.8165 * norm >= 0) continue;
        b[0] = Y1 * c[3];
        b[1] = Y1 * c[1];
        b[2] = Y1 * c[2];
        a[0] = xx - zz;
        a[4] = -zz - xx;
        a[8] = 2 * zz;
        a[1] = a[3] = xy;
        a[2] = a[6] = xz;
        a[5] = a[7] = yz;
        const least = minimumOnSphere(length, norm);
        if (!(least < 0) || mean + least >= 0) continue;
        const window = (Math.max(mean, 0) / -least) * (1 - 1e-6);
        for (let i = 1; i < 9; ++i) radiance[3 * i + channel] *= window;
    }
}

/** Squared component of b along eigenvector k. */
function along(k) {
    return (b[0] * v[k] + b[1] * v[3 + k] + b[2] * v[6 + k]) ** 2;
}

/** A tight lower bound of n·A·n + b·n over unit vectors n (Moré and Sorensen 1983). @param {number} length of b @param {number} norm of A */
function minimumOnSphere(length, norm) {
    diagonalize(norm);
    const x = along(0), y = along(1), z = along(2);
    const least = Math.min(a[0], a[4], a[8]);
    let low = -least + 1e-10 * Math.max(length, Math.abs(least));
    let high = Math.max(low, -least + 0.5 * length);
    for (let i = 0; i < 50; ++i) {
        const middle = 0.5 * (low + high);
        const p = a[0] + middle, q = a[4] + middle, r = a[8] + middle;
        if (x / (p * p) + y / (q * q) + z / (r * r) > 4) low = middle;
        else high = middle;
    }
    return -high - 0.25 * (x / (a[0] + high) + y / (a[4] + high) + z / (a[8] + high));
}

/** Leaves the eigenvalues of symmetric A in its diagonal, and its eigenvectors as columns of v (Jacobi 1846, cyclic rotations). */
function diagonalize(norm) {
    v.fill(0);
    v[0] = v[4] = v[8] = 1;
    for (let sweep = 0; sweep < 12; ++sweep) {
        if (Math.abs(a[1]) + Math.abs(a[2]) + Math.abs(a[5]) <= DIAGONAL * norm) return;
        rotate(0, 1);
        rotate(0, 2);
        rotate(1, 2);
    }
}

function rotate(p, q) {
    const off = a[3 * p + q];
    if (off === 0) return;
    const theta = (0.5 * (a[4 * q] - a[4 * p])) / off;
    const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
    const cosine = 1 / Math.sqrt(t * t + 1);
    const sine = t * cosine;
    for (let k = 0; k < 3; ++k) {
        const x = a[3 * k + p], y = a[3 * k + q];
        a[3 * k + p] = cosine * x - sine * y;
        a[3 * k + q] = sine * x + cosine * y;
    }
    for (let k = 0; k < 3; ++k) {
        const x = a[3 * p + k], y = a[3 * q + k];
        a[3 * p + k] = cosine * x - sine * y;
        a[3 * q + k] = sine * x + cosine * y;
        const i = v[3 * k + p], j = v[3 * k + q];
        v[3 * k + p] = cosine * i - sine * j;
        v[3 * k + q] = sine * i + cosine * j;
    }
    a[3 * p + q] = a[3 * q + p] = 0;
}
