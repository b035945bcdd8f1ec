"""Triangle meshes of closed solids.

A Mesh is a soup of triangles, each three positions and three texture coordinates (or None: projected from the side the
triangle faces). Every function below returns closed solids, counter-clockwise seen from outside, unless its name says
otherwise. Right-handed, Y up, metres.
"""

import math
from collections import defaultdict


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def mul(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def normalize(a):
    n = length(a)
    return (a[0] / n, a[1] / n, a[2] / n)


def place_key(p):
    """The same for points that are one: within some 10 micrometres."""
    return (round(p[0] * 1e5), round(p[1] * 1e5), round(p[2] * 1e5))


class Mesh:
    """A soup of triangles ((p, p, p), (uv, uv, uv) or None)."""

    def __init__(self, triangles=None):
        self.triangles = triangles if triangles is not None else []

    def triangle(self, a, b, c, uv=None):
        # Poles and mitres collapse some triangles to lines: they are left out here rather than asked about everywhere.
        ka, kb, kc = place_key(a), place_key(b), place_key(c)
        if ka != kb and kb != kc and kc != ka:
            self.triangles.append(((a, b, c), uv))

    def quad(self, a, b, c, d, uv=None):
        self.triangle(a, b, c, (uv[0], uv[1], uv[2]) if uv else None)
        self.triangle(a, c, d, (uv[0], uv[2], uv[3]) if uv else None)

    def __add__(self, other):
        return Mesh(self.triangles + other.triangles)

    def map(self, function):
        """Positions through `function`; winding turns with it when it mirrors."""
        mirrored = dot(cross(sub(function((1, 0, 0)), function((0, 0, 0))), sub(function((0, 1, 0)), function((0, 0, 0)))),
                       sub(function((0, 0, 1)), function((0, 0, 0)))) < 0
        result = []
        for points, uv in self.triangles:
            points = tuple(function(p) for p in points)
            if mirrored:
                points = (points[0], points[2], points[1])
                uv = (uv[0], uv[2], uv[1]) if uv else None
            result.append((points, uv))
        return Mesh(result)

    def moved(self, x, y, z):
        return self.map(lambda p: (p[0] + x, p[1] + y, p[2] + z))

    def scaled(self, x, y, z):
        return self.map(lambda p: (p[0] * x, p[1] * y, p[2] * z))

    def turned(self, axis, degrees):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]

        def rotate(p):
            q = list(p)
            q[i], q[j] = c * p[i] - s * p[j], s * p[i] + c * p[j]
            return tuple(q)

        return self.map(rotate)

    def outward(self):
        """The same solid, wound so that its volume is positive."""
        if volume(self.triangles) >= 0:
            return self
        return Mesh([((a, c, b), (uv[0], uv[2], uv[1]) if uv else None) for (a, b, c), uv in self.triangles])


def volume(triangles):
    return sum(dot(a, cross(b, c)) for (a, b, c), _ in triangles) / 6.0


# ---------------------------------------------------------------------------------------------------------------------
# Solids


def box(x0, y0, z0, x1, y1, z1):
    return grid_solid([x0, x1], [y0, y1], [z0, z1], lambda x, y, z: True)


def bevel_box(sx, sy, sz, bevel=0.02):
    """Box of that size standing on the origin's plane, with chamfered edges."""
    hx, hy, hz = sx / 2, sy / 2, sz / 2
    mesh = Mesh()

    def v(x, y, z, axis):
        inset = [bevel] * 3
        inset[axis] = 0.0
        return (x * (hx - inset[0]), y * (hy - inset[1]) + hy, z * (hz - inset[2]))

    for axis in range(3):
        for side in (-1, 1):
            corners = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                sign = [0, 0, 0]
                sign[axis], sign[(axis + 1) % 3], sign[(axis + 2) % 3] = side, a, b
                corners.append(v(*sign, axis))
            mesh.quad(*(corners if side > 0 else corners[::-1]))
    for axis in range(3):  # the edges along `axis`
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for sb in (-1, 1):
            for sc in (-1, 1):
                lo, hi = [0, 0, 0], [0, 0, 0]
                lo[axis], hi[axis] = -1, 1
                lo[b] = hi[b] = sb
                lo[c] = hi[c] = sc
                ring = [v(*lo, b), v(*hi, b), v(*hi, c), v(*lo, c)]
                mesh.quad(*(ring[::-1] if sb * sc > 0 else ring))
    for sx_ in (-1, 1):
        for sy_ in (-1, 1):
            for sz_ in (-1, 1):
                corner = [v(sx_, sy_, sz_, axis) for axis in range(3)]
                mesh.triangle(*(corner if sx_ * sy_ * sz_ > 0 else corner[::-1]))
    return mesh


def grid_solid(xs, ys, zs, filled, sink=None):
    """Union of the cells of a rectilinear grid where filled(x, y, z) of the cell's centre holds, as one closed surface
    without inner faces or T-junctions. `sink(centre, normal)` may give the Mesh that a face goes to."""
    mesh = Mesh()
    size = (len(xs) - 1, len(ys) - 1, len(zs) - 1)
    axes = (xs, ys, zs)

    def solid(i):
        if any(i[a] < 0 or i[a] >= size[a] for a in range(3)):
            return False
        return filled(*((axes[a][i[a]] + axes[a][i[a] + 1]) / 2 for a in range(3)))

    occupied = {(i, j, k): solid((i, j, k)) for i in range(size[0]) for j in range(size[1]) for k in range(size[2])}
    for cell, full in occupied.items():
        if not full:
            continue
        for axis in range(3):
            b, c = (axis + 1) % 3, (axis + 2) % 3
            for side in (0, 1):
                other = list(cell)
                other[axis] += 2 * side - 1
                if occupied.get(tuple(other), False):
                    continue
                ring = []
                for db, dc in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    p = [0.0, 0.0, 0.0]
                    p[axis] = axes[axis][cell[axis] + side]
                    p[b] = axes[b][cell[b] + db]
                    p[c] = axes[c][cell[c] + dc]
                    ring.append(tuple(p))
                centre = mul(add(ring[0], ring[2]), 0.5)
                normal = [0, 0, 0]
                normal[axis] = 2 * side - 1
                target = sink(centre, tuple(normal)) if sink else mesh
                target.quad(*(ring if side else ring[::-1]))
    return mesh


def lathe(profile, segments, density=1.0, u_repeats=None):
    """Turns (radius, height) points, bottom to top, around Y. First and last radius are 0, so that the solid is closed."""
    assert profile[0][0] == 0 and profile[-1][0] == 0
    mesh = Mesh()
    reference = max(r for r, _ in profile)
    repeats = u_repeats or max(1, round(2 * math.pi * reference * density))
    ring = [(math.cos(2 * math.pi * i / segments), math.sin(2 * math.pi * i / segments)) for i in range(segments)]
    along = 0.0
    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        step = math.hypot(r1 - r0, y1 - y0) * density
        v0, v1 = -along, -(along + step)
        along += step
        for i in range(segments):
            (c0, s0), (c1, s1) = ring[i], ring[(i + 1) % segments]
            # Angles run from +X to +Z, which seen from outside is leftwards: u runs the other way.
            u0, u1 = -repeats * i / segments, -repeats * (i + 1) / segments
            mesh.quad((r0 * c1, y0, r0 * s1), (r0 * c0, y0, r0 * s0), (r1 * c0, y1, r1 * s0), (r1 * c1, y1, r1 * s1),
                      ((u1, v0), (u0, v0), (u0, v1), (u1, v1)))
    return mesh.outward()


def sphere(radius, segments=48, rings=24, density=1.0):
    points = [(radius * math.sin(math.pi * i / rings), -radius * math.cos(math.pi * i / rings)) for i in range(rings + 1)]
    points[0], points[-1] = (0, -radius), (0, radius)
    return lathe(points, segments, density)


def cylinder(radius, height, segments=24, bevel=0.0, density=1.0):
    b = bevel
    points = [(0, 0), (radius - b, 0), (radius, b), (radius, height - b), (radius - b, height), (0, height)]
    return lathe([p for i, p in enumerate(points) if i == 0 or p != points[i - 1]], segments, density)


def sweep(profile, frames, closed=False, density=1.0):
    """Carries a polygon of (x, y) points along frames (origin, x axis, y axis); the ends are capped unless closed."""
    mesh = Mesh()
    rows = [[add(o, add(mul(ax, x), mul(ay, y))) for x, y in profile] for o, ax, ay in frames]
    around = [0.0]
    for (x0, y0), (x1, y1) in zip(profile, profile[1:] + profile[:1]):
        around.append(around[-1] + math.hypot(x1 - x0, y1 - y0) * density)
    n, along = len(profile), 0.0
    for k in range(len(rows) if closed else len(rows) - 1):
        a, b = rows[k], rows[(k + 1) % len(rows)]
        step = length(sub(frames[(k + 1) % len(rows)][0], frames[k][0])) * density
        for i in range(n):
            j = (i + 1) % n
            u0, u1, v0, v1 = along, along + step, around[i], around[i + 1]
            mesh.quad(a[i], b[i], b[j], a[j], ((u0, v0), (u1, v0), (u1, v1), (u0, v1)))
        along += step
    if not closed:
        for row, flip in ((rows[0], False), (rows[-1], True)):
            for a, b, c in ear_clip(profile):
                mesh.triangle(*((row[c], row[b], row[a]) if flip else (row[a], row[b], row[c])))
    return mesh.outward()


def ear_clip(polygon):
    """Triangulates a simple polygon; index triples wound as the polygon."""
    indices = list(range(len(polygon)))
    area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(polygon, polygon[1:] + polygon[:1]))
    sign = 1 if area > 0 else -1

    def turn(a, b, c):
        return sign * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))

    triangles = []
    while len(indices) > 3:
        for k in range(len(indices)):
            i, j, l = indices[k - 1], indices[k], indices[(k + 1) % len(indices)]
            a, b, c = polygon[i], polygon[j], polygon[l]
            if turn(a, b, c) <= 1e-12:
                continue
            if any(turn(a, b, polygon[m]) >= 0 and turn(b, c, polygon[m]) >= 0 and turn(c, a, polygon[m]) >= 0
                   for m in indices if m not in (i, j, l)):
                continue
            triangles.append((i, j, l))
            indices.pop(k)
            break
        else:
            raise ValueError("polygon is not simple")
    triangles.append(tuple(indices))
    return triangles


def miter_frames(path, closed):
    """Frames along a horizontal polyline of (x, z): x axis to the right of the way (stretched at corners), y axis up."""
    frames, n = [], len(path)
    for i in range(n):
        directions = []
        for a, b in ((i - 1, i), (i, i + 1)):
            if closed or (a >= 0 and b < n):
                p, q = path[a % n], path[b % n]
                l = math.hypot(q[0] - p[0], q[1] - p[1])
                directions.append(((q[0] - p[0]) / l, (q[1] - p[1]) / l))
        rights = [(-dz, dx) for dx, dz in directions]
        mx, mz = sum(r[0] for r in rights), sum(r[1] for r in rights)
        l = math.hypot(mx, mz)
        mx, mz = mx / l, mz / l
        stretch = 1.0 / (mx * rights[0][0] + mz * rights[0][1])
        frames.append(((path[i][0], 0.0, path[i][1]), (mx * stretch, 0.0, mz * stretch), (0.0, 1.0, 0.0)))
    return frames


def bar(start, end, radius, segments=8, density=1.0):
    """Round bar between two points."""
    axis = normalize(sub(end, start))
    helper = (0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0)
    ax = normalize(cross(helper, axis))
    ay = cross(axis, ax)
    circle = [(radius * math.cos(2 * math.pi * i / segments), radius * math.sin(2 * math.pi * i / segments))
              for i in range(segments)]
    return sweep(circle, [(start, ax, ay), (end, ax, ay)], density=density)


def tube(points, radii, segments=12, closed=False, density=1.0):
    """Round tube along a curve, its frame carried from point to point; when closed, the frame's total twist is spread out."""
    n = len(points)
    tangents = []
    for i in range(n):
        a = points[(i - 1) % n] if closed or i > 0 else points[i]
        b = points[(i + 1) % n] if closed or i < n - 1 else points[i]
        tangents.append(normalize(sub(b, a)))
    helper = (0.0, 1.0, 0.0) if abs(tangents[0][1]) < 0.9 else (1.0, 0.0, 0.0)
    ax = normalize(sub(helper, mul(tangents[0], dot(helper, tangents[0]))))
    axes = [ax]
    for t in tangents[1:] + ([tangents[0]] if closed else []):
        ax = normalize(sub(ax, mul(t, dot(ax, t))))
        axes.append(ax)
    twist = 0.0
    if closed:
        ay = cross(tangents[0], axes[0])
        twist = math.atan2(dot(axes[-1], ay), dot(axes[-1], axes[0]))
    frames = []
    for i in range(n):
        a, c, s = axes[i], math.cos(-twist * i / n), math.sin(-twist * i / n)
        b = cross(tangents[i], a)
        a, b = add(mul(a, c), mul(b, s)), sub(mul(b, c), mul(a, s))
        frames.append((points[i], mul(a, radii[i]), mul(b, radii[i])))
    circle = [(math.cos(2 * math.pi * i / segments), math.sin(2 * math.pi * i / segments)) for i in range(segments)]
    return sweep(circle, frames, closed, density)


def extrude_slabs(slabs, z0, z1):
    """Solid of vertical slabs (x0, x1, [(bottom0, top0, bottom1, top1), …]), contiguous in x, between z0 and z1: walls with
    arches and openings, stairs. The breaks of neighbouring slabs are shared, so no T-junctions arise."""
    mesh = Mesh()
    lines = defaultdict(set)
    snap = lambda y: round(y, 6)
    for k, (_, _, intervals) in enumerate(slabs):
        for b0, t0, b1, t1 in intervals:
            lines[k].update((snap(b0), snap(t0)))
            lines[k + 1].update((snap(b1), snap(t1)))

    def chain(k, low, high):
        return [y for y in sorted(lines[k]) if snap(low) <= y <= snap(high)]

    for k, (x0, x1, intervals) in enumerate(slabs):
        for b0, t0, b1, t1 in intervals:
            left, right = chain(k, b0, t0), chain(k + 1, b1, t1)
            i = j = 0
            while i < len(left) - 1 or j < len(right) - 1:
                # Advance the chain whose next point lies lower, seen along each chain's own span.
                up_left = i < len(left) - 1 and (j == len(right) - 1 or left[i + 1] <= right[j + 1])
                for z, front in ((z1, True), (z0, False)):
                    a, b = (x0, left[i], z), (x1, right[j], z)
                    c = (x0, left[i + 1], z) if up_left else (x1, right[j + 1], z)
                    mesh.triangle(*((a, b, c) if front else (a, c, b)))
                i, j = (i + 1, j) if up_left else (i, j + 1)
            b0, t0, b1, t1 = snap(b0), snap(t0), snap(b1), snap(t1)
            mesh.quad((x0, t0, z1), (x1, t1, z1), (x1, t1, z0), (x0, t0, z0))
            mesh.quad((x0, b0, z0), (x1, b1, z0), (x1, b1, z1), (x0, b0, z1))
    for k in range(len(slabs) + 1):
        x = slabs[k][0] if k < len(slabs) else slabs[-1][1]
        ys = sorted(lines[k])
        for ya, yb in zip(ys, ys[1:]):
            middle = (ya + yb) / 2
            left = k > 0 and any(b1 < middle < t1 for _, _, b1, t1 in slabs[k - 1][2])
            right = k < len(slabs) and any(b0 < middle < t0 for b0, t0, _, _ in slabs[k][2])
            if left and not right:
                mesh.quad((x, ya, z1), (x, ya, z0), (x, yb, z0), (x, yb, z1))
            elif right and not left:
                mesh.quad((x, ya, z0), (x, ya, z1), (x, yb, z1), (x, yb, z0))
    return mesh


def card(centre, normal, up, width, height, uv):
    """One quad with its picture (open: for leaves); uv = (u0, v0, u1, v1)."""
    right = normalize(cross(up, normal))
    top = cross(normalize(normal), right)
    r, t = mul(right, width / 2), mul(top, height / 2)
    u0, v0, u1, v1 = uv
    mesh = Mesh()
    mesh.quad(sub(sub(centre, r), t), sub(add(centre, r), t), add(add(centre, r), t), add(sub(centre, r), t),
              ((u0, v1), (u1, v1), (u1, v0), (u0, v0)))
    return mesh
