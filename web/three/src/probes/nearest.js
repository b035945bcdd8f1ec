// The point of a triangle that is nearest to the origin.
const normal = new Float64Array(3);

/** Of vertices a, b of a list, each of three numbers: the part of their cross product along `normal`. */
function along(v, a, b) {
    return normal[0] * (v[a + 1] * v[b + 2] - v[a + 2] * v[b + 1]) + normal[1] * (v[a + 2] * v[b] - v[a] * v[b + 2]) + normal[2] * (v[a] * v[b + 1] - v[a + 1] * v[b]);
}

/** @param {Float64Array} v three vertices @param {Float64Array} weights becomes the barycentric coordinates */
export function nearestOnTriangle(v, weights) {
    const ux = v[3] - v[0], uy = v[4] - v[1], uz = v[5] - v[2];
    const wx = v[6] - v[0], wy = v[7] - v[1], wz = v[8] - v[2];
    normal[0] = uy * wz - uz * wy;
    normal[1] = uz * wx - ux * wz;
    normal[2] = ux * wy - uy * wx;
    const a = along(v, 3, 6);
    const b = along(v, 6, 0);
    const c = along(v, 0, 3);
    const total = a + b + c;
    if (a >= 0 && b >= 0 && c >= 0 && total > 0) {
        weights[0] = a / total;
        weights[1] = b / total;
        weights[2] = c / total;
        return;
    }
    let best = Infinity;
    for (let i = 0; i < 3; ++i) {
        const j = (i + 1) % 3;
        const x = v[3 * i], y = v[3 * i + 1], z = v[3 * i + 2];
        const ex = v[3 * j] - x, ey = v[3 * j + 1] - y, ez = v[3 * j + 2] - z;
        const length = ex * ex + ey * ey + ez * ez;
        const t = length > 0 ? Math.min(Math.max(-(x * ex + y * ey + z * ez) / length, 0), 1) : 0;
        const distance = (x + t * ex) ** 2 + (y + t * ey) ** 2 + (z + t * ez) ** 2;
        if (distance >= best) continue;
        best = distance;
        weights[0] = weights[1] = weights[2] = 0;
        weights[i] = 1 - t;
        weights[j] = t;
    }
}
