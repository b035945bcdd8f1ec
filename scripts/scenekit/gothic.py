"""Parts of the chapel: walls with pointed openings, pillars, ribs, tracery and glass. Each a list of (Mesh, material, texture
repeats per metre), as in parts.py."""

import math

from . import mesh as m
from .mesh import Mesh
from .parts import arc

STONE = "stone"


def pointed(middle, spring, half, radius, steps=14):
    """Points (x, y) of a pointed arch from its left springing over the apex to the right one; `radius` of both arcs."""
    end = math.degrees(math.acos((half - radius) / radius))
    left = arc(middle - half + radius, spring, radius, 180, end, steps)
    return left + [(2 * middle - x, y) for x, y in reversed(left[:-1])]


def apex(spring, half, radius):
    return spring + math.sqrt(radius * radius - (radius - half) ** 2)


class Opening:
    """A hole in a wall between two curves over x; without a lower one it is open down to the wall's foot."""

    def __init__(self, upper, lower=None):
        self.upper = sorted(upper)
        self.lower = sorted(lower) if lower else None

    def covers(self, x0, x1):
        return self.upper[0][0] <= x0 + 1e-9 and x1 <= self.upper[-1][0] + 1e-9

    def breaks(self):
        return [round(x, 6) for x, _ in self.upper + (self.lower or [])]


def height_at(curve, x):
    for (x0, y0), (x1, y1) in zip(curve, curve[1:]):
        if x <= x1 + 1e-9:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return curve[-1][1]


def lancet(middle, sill, spring, half, radius):
    upper = pointed(middle, spring, half, radius)
    return Opening(upper, [(middle - half, sill), (middle + half, sill)])


def round_window(middle, height, radius, steps=28):
    upper = [(x, y) for x, y in arc(middle, height, radius, 0, 180, steps)]
    return Opening(upper, [(x, 2 * height - y) for x, y in upper])


def wall(x0, x1, low, high, openings, z0, z1):
    """Solid wall along x between two heights, with openings one above the other or side by side."""
    cuts = sorted({round(x0, 6), round(x1, 6), *(x for opening in openings for x in opening.breaks())})
    slabs = []
    for a, b in zip(cuts, cuts[1:]):
        here = sorted((o for o in openings if o.covers(a, b)), key=lambda o: height_at(o.upper, (a + b) / 2))
        from_a = from_b = low
        intervals = []
        for opening in here:
            if opening.lower:
                intervals.append((from_a, height_at(opening.lower, a), from_b, height_at(opening.lower, b)))
            from_a, from_b = height_at(opening.upper, a), height_at(opening.upper, b)
        slabs.append((a, b, intervals + [(from_a, high, from_b, high)]))
    return m.extrude_slabs(slabs, z0, z1)


def trim(outline, profile, closed=True):
    """Carries a profile of (outwards, z) along points (x, y)."""
    frames = [((x, y, 0.0), (ax, ay, 0.0), (0.0, 0.0, 1.0)) for (x, _, y), (ax, _, ay), _ in m.miter_frames(outline, closed)]
    return Mesh([(t, None) for t, _ in m.sweep(profile, frames, closed).triangles])


def rectangle(out0, out1, z0, z1, bevel=0.0):
    if not bevel:
        return [(out0, z0), (out1, z0), (out1, z1), (out0, z1)]
    return [(out0, z0), (out1, z0), (out1, z1 - bevel), (out1 - bevel, z1), (out0 + bevel, z1), (out0, z1 - bevel)]


def outline(sill, spring, half, radius):
    return [(-half, sill), (half, sill)] + list(reversed(pointed(0.0, spring, half, radius)))


def lancet_frame(sill, spring, half, radius):
    """Moulded stone around the inner side of an opening, and iron bars across the glass. The wall's face is z = 0, inside is +z."""
    stone = trim(outline(sill, spring, half, radius), [(-0.16, 0.05), (-0.16, -0.03), (0.03, -0.03), (0.03, 0.03), (-0.02, 0.06), (-0.1, 0.06)])
    iron = Mesh()
    for y in (sill + 0.42, sill + 0.84, sill + 1.26, spring + 0.1):
        iron += m.bar((-half - 0.02, y, -0.26), (half + 0.02, y, -0.26), 0.012, 6)
    iron += m.bar((0, sill - 0.02, -0.24), (0, apex(spring, half, radius) + 0.02, -0.24), 0.014, 6)
    return [(stone, STONE, 1.0), (iron, "iron", 1.0)]


def pane(points, glass, box):
    """One sheet of glass in the plane z = 0 (open), its picture over the box (x0, y0, x1, y1)."""
    x0, y0, x1, y1 = box
    sheet = Mesh()
    place = lambda p: ((p[0] - x0) / (x1 - x0), (y1 - p[1]) / (y1 - y0))
    for i, j, k in m.ear_clip(points):
        a, b, c = points[i], points[j], points[k]
        sheet.triangle((*a, 0.0), (*b, 0.0), (*c, 0.0), (place(a), place(b), place(c)))
    return [(sheet, glass, 1.0)]


def lancet_pane(sill, spring, half, radius, glass):
    more = 0.02  # it ends in the wall
    top = apex(spring, half, radius)
    return pane(list(reversed(outline(sill - more, spring, half + more, radius + more)))[::-1], glass, (-half, sill, half, top))


def rose_pane(radius, glass):
    return pane(arc(0, 0, radius + 0.02, 0, 360, 48)[:-1], glass, (-radius, -radius, radius, radius))


def rose_tracery(radius, petals=12):
    """Stone wheel: rim, two rings, spokes, and a circle between each pair of spokes."""
    def ring(r, half, depth, steps=48):
        return trim(arc(0, 0, r, 0, 360, steps)[:-1], rectangle(-half, half, -depth, depth))

    solid = ring(radius - 0.02, 0.07, 0.1) + ring(radius * 0.17, 0.035, 0.07, 24) + ring(radius * 0.5, 0.025, 0.06)
    solid += m.cylinder(radius * 0.07, 0.16, 20, 0.02).turned("x", 90).moved(0, 0, -0.08)
    for i in range(petals):
        a = math.tau * i / petals
        c, s = math.cos(a), math.sin(a)
        solid += m.bar((radius * 0.16 * c, radius * 0.16 * s, 0), (radius * c, radius * s, 0), 0.03, 8)
        b = a + math.pi / petals
        solid += ring(radius * 0.155, 0.018, 0.045, 20).moved(radius * 0.78 * math.cos(b), radius * 0.78 * math.sin(b), 0)
    return [(solid, STONE, 1.0)]


def pillar(height):
    """Clustered pillar: plinth, round core with four shafts, bases and capitals."""
    core = m.lathe([(0, 0.2), (0.3, 0.2), (0.3, 0.24), (0.26, 0.3), (0.245, 0.36), (0.245, height - 0.46), (0.27, height - 0.43),
                    (0.27, height - 0.4), (0.25, height - 0.38), (0.27, height - 0.3), (0.34, height - 0.14), (0, height - 0.14)], 32)
    shaft = m.lathe([(0, 0.2), (0.115, 0.2), (0.115, 0.24), (0.085, 0.3), (0.08, 0.34), (0.08, height - 0.44), (0.1, height - 0.42), (0.1, height - 0.39),
                     (0.085, height - 0.37), (0.1, height - 0.29), (0.15, height - 0.14), (0, height - 0.14)], 20)
    solid = core + m.bevel_box(0.86, 0.14, 0.86, 0.02).moved(0, -0.01, 0) + m.bevel_box(0.76, 0.1, 0.76, 0.03).moved(0, 0.12, 0)
    for x, z in ((0.26, 0), (-0.26, 0), (0, 0.26), (0, -0.26)):
        solid += shaft.moved(x, 0, z)
    solid += leaf_ring(0.29, 12, height - 0.27)
    solid += m.bevel_box(0.84, 0.07, 0.84, 0.015).moved(0, height - 0.15, 0) + m.bevel_box(0.78, 0.1, 0.78, 0.02).moved(0, height - 0.09, 0)
    return [(solid, STONE, 1.0)]


def leaf_ring(radius, count, height):
    """Stylised leaves of a capital."""
    solid = Mesh()
    leaf = m.sphere(1.0, 8, 6).scaled(0.055, 0.1, 0.03)
    for i in range(count):
        solid += leaf.turned("x", 24).moved(0, height, radius).turned("y", 360 * i / count)
    return solid


def vault(half, spring, radius, top, z0, z1):
    curve = pointed(0.0, spring, half, radius, 18)
    slabs = [(-half - 0.3, -half, [(spring, top, spring, top)])]
    slabs += [(x0, x1, [(y0, top, y1, top)]) for (x0, y0), (x1, y1) in zip(curve, curve[1:])]
    slabs += [(half, half + 0.3, [(spring, top, spring, top)])]
    return [(m.extrude_slabs(slabs, z0, z1), "plaster", 0.5)]


def rib(half, spring, radius):
    curve = pointed(0.0, spring, half, radius, 18)
    profile = [(0.06, -0.13), (0.06, 0.13), (-0.06, 0.13), (-0.12, 0.07), (-0.12, -0.07), (-0.06, -0.13)]
    return [(trim([(-half, spring - 0.05)] + curve + [(half, spring - 0.05)], [(-o, z) for o, z in profile], closed=False), STONE, 1.0)]


def arch_moulding(half, spring, radius, face):
    """Raised moulding around an arch of the arcade, on both faces of its wall."""
    curve = pointed(0.0, spring, half, radius)
    solid = Mesh()
    for side in (-1, 1):
        z0, z1 = sorted((side * (face - 0.04), side * (face + 0.05)))
        solid += trim(curve, rectangle(-0.2, 0.015, z0, z1), closed=False)
    return [(solid, STONE, 1.0)]
