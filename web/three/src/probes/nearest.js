// The point of a triangle that is nearest to the origin.
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

/** Barycentric coordinates. @param {number[]} a @param {number[]} b @param {number[]} c @returns {number[]} */
export function nearestOnTriangle(a, b, c) {
    const normal = cross(minus(b, a), minus(c, a));
    const part = [dot(normal, cross(b, c)), dot(normal, cross(c, a)), dot(normal, cross(a, b))];
    const total = part[0] + part[1] + part[2];
    if (part.every((x) => x >= 0) && total > 0) return part.map((x) => x / total);
    const v = [a, b, c];
    let best = [1, 0, 0];
    let bestDistance = Infinity;
    for (let i = 0; i < 3; ++i) {
        const j = (i + 1) % 3;
        const edge = minus(v[j], v[i]);
        const length = dot(edge, edge);
        const t = length > 0 ? Math.min(Math.max(-dot(v[i], edge) / length, 0), 1) : 0;
        const point = v[i].map((x, axis) => x + t * edge[axis]);
        const distance = dot(point, point);
        if (distance >= bestDistance) continue;
        bestDistance = distance;
        best = [0, 0, 0];
        best[i] = 1 - t;
        best[j] = t;
    }
    return best;
}
