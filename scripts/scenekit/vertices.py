"""From triangle soups to vertex arrays: crease-angle normals, texture coordinates in metres, and checks of both."""

import math
from collections import defaultdict

from .mesh import add, cross, dot, length, mul, normalize, place_key, sub


def projected_uv(p, normal, density):
    """Box projection: right and down as seen when looking at the face, in metres times density."""
    ax, ay, az = abs(normal[0]), abs(normal[1]), abs(normal[2])
    if ay >= ax and ay >= az:
        return (p[0] * density, p[2] * density * (1 if normal[1] > 0 else -1))
    if ax >= az:
        return (p[2] * density * (-1 if normal[0] > 0 else 1), -p[1] * density)
    return (p[0] * density * (1 if normal[2] > 0 else -1), -p[1] * density)


def vertex_arrays(mesh, density=1.0, crease_degrees=35.0, tangents=False):
    """Indexed positions, normals, texture coordinates (and tangents): normals are smooth where faces meet at less than
    the crease angle (angle-weighted: Thürmer and Wüthrich 1998), flat elsewhere."""
    faces, around = [], defaultdict(list)
    for (a, b, c), uv in mesh.triangles:
        n = cross(sub(b, a), sub(c, a))
        area = length(n)
        if area < 1e-10:
            continue
        n = mul(n, 1.0 / area)
        index = len(faces)
        faces.append(((a, b, c), uv or tuple(projected_uv(p, n, density) for p in (a, b, c)), n))
        for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
            e, f = normalize(sub(q, p)), normalize(sub(r, p))
            around[place_key(p)].append((index, math.acos(max(-1.0, min(1.0, dot(e, f))))))
    limit = math.cos(math.radians(crease_degrees))
    arrays = {"position": [], "normal": [], "uv": [], "index": []}
    known, tangent_sum, bitangent_sum = {}, [], []
    for points, uvs, n in faces:
        corner = []
        for p, uv in zip(points, uvs):
            total = (0.0, 0.0, 0.0)
            for other, angle in around[place_key(p)]:
                if dot(n, faces[other][2]) > limit:
                    total = add(total, mul(faces[other][2], angle))
            normal = normalize(total)
            key = (place_key(p), tuple(round(x * 1e4) for x in normal), (round(uv[0] * 1e4), round(uv[1] * 1e4)))
            if tangents:
                key += (_handed(points, uvs) > 0,)
            if key not in known:
                known[key] = len(arrays["position"])
                arrays["position"].append(tuple(round(x, 5) + 0.0 for x in p))
                arrays["normal"].append(normal)
                arrays["uv"].append((round(uv[0], 5) + 0.0, round(uv[1], 5) + 0.0))
                tangent_sum.append((0.0, 0.0, 0.0))
                bitangent_sum.append((0.0, 0.0, 0.0))
            corner.append(known[key])
        arrays["index"].extend(corner)
        if tangents:
            t, b = _gradients(points, uvs)
            for v in corner:
                tangent_sum[v], bitangent_sum[v] = add(tangent_sum[v], t), add(bitangent_sum[v], b)
    if tangents:
        arrays["tangent"] = []
        for normal, t, b in zip(arrays["normal"], tangent_sum, bitangent_sum):
            t = sub(t, mul(normal, dot(normal, t)))
            if length(t) < 1e-6:
                t = cross((0.0, 1.0, 0.0) if abs(normal[1]) < 0.9 else (1.0, 0.0, 0.0), normal)
            t = normalize(t)
            arrays["tangent"].append((*t, 1.0 if dot(cross(normal, t), b) >= 0 else -1.0))
    return arrays


def _handed(points, uvs):
    (u0, v0), (u1, v1), (u2, v2) = uvs
    return (u1 - u0) * (v2 - v0) - (u2 - u0) * (v1 - v0)


def _gradients(points, uvs):
    """Directions of growing u and of falling v (the picture's up), area-weighted."""
    (u0, v0), (u1, v1), (u2, v2) = uvs
    e1, e2 = sub(points[1], points[0]), sub(points[2], points[0])
    d = _handed(points, uvs)
    sign = 1.0 if d >= 0 else -1.0
    t = mul(sub(mul(e1, v2 - v0), mul(e2, v1 - v0)), sign)
    b = mul(sub(mul(e1, u2 - u0), mul(e2, u1 - u0)), sign)
    return t, b


# ---------------------------------------------------------------------------------------------------------------------
# Self-check


def check_closed(triangles, what):
    """Every edge is walked as often one way as the other, and every connected piece has positive volume: the soup bounds
    solids, wound outwards. Raises ValueError with the place of the first fault."""
    edges, parent = defaultdict(int), {}

    def find(a):
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        return a

    for (a, b, c), _ in triangles:
        keys = (place_key(a), place_key(b), place_key(c))
        for k in keys:
            parent.setdefault(k, k)
        for p, q in zip(keys, keys[1:] + keys[:1]):
            edges[(p, q)] += 1
            parent[find(p)] = find(q)
    for (p, q), count in edges.items():
        if edges.get((q, p), 0) != count:
            raise ValueError(f"{what}: open edge at {tuple(x / 1e5 for x in p)} - {tuple(x / 1e5 for x in q)}")
    volumes = defaultdict(float)
    for (a, b, c), _ in triangles:
        volumes[find(place_key(a))] += dot(a, cross(b, c)) / 6.0
    for root, value in volumes.items():
        if value <= 0:
            raise ValueError(f"{what}: piece at {tuple(x / 1e5 for x in root)} is inside out (volume {value:g})")


def check_arrays(arrays, what):
    """Unit normals (and tangents) that agree with the winding, no degenerate triangles, indices in range, finite uv."""
    positions, normals = arrays["position"], arrays["normal"]
    for name in ("normal", "tangent"):
        for n in arrays.get(name, []):
            if abs(length(n) - 1.0) > 1e-4:
                raise ValueError(f"{what}: {name} of length {length(n)}")
    for i in range(0, len(arrays["index"]), 3):
        triple = arrays["index"][i:i + 3]
        a, b, c = (positions[v] for v in triple)
        n = cross(sub(b, a), sub(c, a))
        area = length(n)
        if area < 1e-10:
            raise ValueError(f"{what}: degenerate triangle at {a}")
        for v in triple:
            if dot(n, normals[v]) / area < 0.3:
                raise ValueError(f"{what}: normal against winding at {positions[v]}")
    for u, v in arrays["uv"]:
        if not (math.isfinite(u) and math.isfinite(v)):
            raise ValueError(f"{what}: texture coordinate not finite")
