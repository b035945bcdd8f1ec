"""The courtyard's building parts and furniture, each a list of (Mesh, material, texture repeats per metre)."""

import math
import random

from . import mesh as m
from .mesh import Mesh

BAY = 2.6  # metres between column axes
SPRING = 2.66  # height of the arches' springing
ARCH_RADIUS = 1.04
FLOOR = 0.16  # walkway above court


def arc(cx, cy, radius, start, end, steps):
    """Points of a circular arc, degrees, both ends included."""
    return [(cx + radius * math.cos(math.radians(start + (end - start) * i / steps)),
             cy + radius * math.sin(math.radians(start + (end - start) * i / steps))) for i in range(steps + 1)]


def column():
    """Tuscan order: square plinth, torus, shaft with entasis, necking, echinus, abacus; 2.5 m high."""
    height = SPRING - FLOOR
    shaft_low, shaft_high = 0.185, 0.155
    profile = [(0, 0.08), (0.235, 0.08)]
    profile += arc(0.235, 0.125, 0.045, -90, 90, 8)[1:]
    profile += [(0.222, 0.17), (0.222, 0.185)]
    profile += arc(0.222, 0.22, 0.035, 180 + 90, 180, 5)[1:] + [(shaft_low, 0.235)]
    for i in range(1, 13):
        t = i / 12
        swell = 0.006 * math.sin(math.pi * min(1.0, t * 1.25))
        profile.append((shaft_low + (shaft_high - shaft_low) * t ** 1.6 + swell, 0.235 + (2.13 - 0.235) * t))
    profile += arc(0.165, 2.155, 0.02, -90, 90, 6) + [(shaft_high, 2.18), (shaft_high, 2.25)]
    profile += [(0.175, 2.26), (0.175, 2.275)]
    profile += arc(0.175, 2.345, 0.07, -80, 0, 6) + [(0.245, 2.37), (0, 2.37)]
    shaft = m.lathe(_distinct(profile), 40, 1.0)
    plinth = m.bevel_box(0.56, 0.11, 0.56, 0.012).moved(0, -0.01, 0)
    abacus = m.bevel_box(0.56, 0.16, 0.56, 0.014).moved(0, height - 0.15, 0)
    return [(shaft + plinth + abacus, "stone", 1.0)]


def _distinct(points):
    return [p for i, p in enumerate(points) if i == 0 or math.hypot(p[0] - points[i - 1][0], p[1] - points[i - 1][1]) > 1e-4]


def pier():
    """Square corner pier with base and cap."""
    height = SPRING - FLOOR
    solid = m.bevel_box(0.5, height + 0.06, 0.5, 0.012) + m.bevel_box(0.62, 0.2, 0.62, 0.02).moved(0, -0.01, 0)
    solid += m.bevel_box(0.56, 0.06, 0.56, 0.012).moved(0, 0.185, 0)
    solid += m.bevel_box(0.6, 0.1, 0.6, 0.014).moved(0, height - 0.095, 0) + m.bevel_box(0.56, 0.06, 0.56, 0.014).moved(0, height - 0.15, 0)
    return [(solid, "stone", 1.0)]


def arcade(bays, extra):
    """Wall over `bays` arches along x, centred, `extra` longer at both ends; from the springing to the slab."""
    top, steps, slabs = 4.32, 28, []
    edge = BAY * bays / 2
    first = -edge - extra
    for bay in range(bays):
        centre = -edge + BAY * (bay + 0.5)
        slabs.append((first, centre - ARCH_RADIUS, [(SPRING, top, SPRING, top)]))
        points = [(x, y) for x, y in reversed(arc(centre, SPRING, ARCH_RADIUS, 0, 180, steps))]
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            slabs.append((x0, x1, [(y0, top, y1, top)]))
        first = centre + ARCH_RADIUS
    slabs.append((first, edge + extra, [(SPRING, top, SPRING, top)]))
    return [(m.extrude_slabs(slabs, -0.225, 0.225), "plaster", 0.5)]


def archivolt():
    """Moulded ring around an arch with its keystone; stands 5 cm proud of the wall's face at z = 0.225."""
    inner, outer, z = ARCH_RADIUS - 0.012, ARCH_RADIUS + 0.2, 0.225
    profile = [(inner, z - 0.05), (outer, z - 0.05), (outer, z + 0.055), (outer - 0.05, z + 0.055), (outer - 0.062, z + 0.035),
               (inner + 0.06, z + 0.035), (inner + 0.05, z + 0.02), (inner, z + 0.02)]
    frames = []
    for i in range(33):
        a = math.radians(180 * i / 32)
        frames.append(((0, SPRING, 0), (math.cos(a), math.sin(a), 0), (0, 0, 1)))
    # The frames share one origin, so the texture runs by projection instead of along the sweep.
    ring = Mesh([(t, None) for t, _ in m.sweep(profile, frames).triangles])
    y0, y1, w0, w1 = SPRING + inner - 0.015, SPRING + outer + 0.07, 0.075, 0.115
    key = m.extrude_slabs([(-w1, -w0, [(y1 - 1e-3, y1, y0, y1)]), (-w0, w0, [(y0, y1, y0, y1)]), (w0, w1, [(y0, y1, y1 - 1e-3, y1)])],
                          z - 0.05, z + 0.085)
    return [(ring + key, "stone", 1.0)]


BALUSTER = [(0, 0), (0.055, 0), (0.055, 0.05), (0.036, 0.062), (0.044, 0.13), (0.06, 0.215),
            (0.033, 0.36), (0.026, 0.46), (0.04, 0.475), (0.04, 0.495), (0.028, 0.51), (0.052, 0.555), (0.052, 0.6), (0, 0.6)]


def balustrade(span, count):
    """Balusters between a base and a hand rail, along x, centred."""
    solid = m.bevel_box(span, 0.1, 0.22, 0.012) + m.bevel_box(span, 0.12, 0.26, 0.025).moved(0, 0.68, 0)
    one = m.lathe(BALUSTER, 12, 1.0)
    for i in range(count):
        solid += one.moved((i + 0.5) * span / count - span / 2, 0.09, 0)
    return [(solid, "stone", 1.0)]


def pedestal():
    solid = m.bevel_box(0.36, 0.86, 0.36, 0.014) + m.bevel_box(0.42, 0.12, 0.42, 0.014).moved(0, -0.01, 0)
    solid += m.bevel_box(0.44, 0.09, 0.44, 0.02).moved(0, 0.8, 0)
    return [(solid, "stone", 1.0)]


def stair(risers, rise, run, landing, width):
    """Flight along +x, its landing last, with an arched passage beneath; from z 0 to width."""
    length = (risers - 1) * run + landing
    passage, radius, spring = length - landing - 0.95, 0.75, 1.75
    points = [(passage - radius, 0.0)] + [(x, y) for x, y in reversed(arc(passage, spring, radius, 0, 180, 24))] + [(passage + radius, 0)]
    cuts = sorted({round(x, 6) for x, _ in points} | {round(i * run, 6) for i in range(risers)} | {round(length, 6)})

    def underside(x):
        if abs(x - passage) >= radius - 1e-6:
            return -0.02 if abs(x - passage) > radius + 1e-6 else spring
        return spring + math.sqrt(radius * radius - (x - passage) ** 2)

    slabs = []
    for x0, x1 in zip(cuts, cuts[1:]):
        middle = (x0 + x1) / 2
        top = rise * min(risers, int(middle / run + 1e-6) + 1) - 0.003
        if abs(middle - passage) < radius:
            # A chord of the circle in x and y both ends, so that neighbouring slabs meet.
            slabs.append((x0, x1, [(underside(x0), top, underside(x1), top)]))
        else:
            slabs.append((x0, x1, [(-0.02, top, -0.02, top)]))
    return [(m.extrude_slabs(slabs, 0, width), "plaster", 0.5)], length


def fountain():
    """Octagonal basin, pedestal and bowl; water apart."""
    basin = m.lathe([(0, -0.02), (1.62, -0.02), (1.62, 0.1), (1.5, 0.13), (1.5, 0.42), (1.6, 0.46), (1.6, 0.53), (1.57, 0.55),
                     (1.27, 0.55), (1.24, 0.53), (1.24, 0.12), (0, 0.12)], 8).turned("y", 22.5)
    basin = Mesh([(t, None) for t, _ in basin.triangles])
    profile = [(0, 0.1), (0.34, 0.1), (0.34, 0.3), (0.26, 0.34), (0.2, 0.42), (0.13, 0.6), (0.12, 0.75), (0.17, 0.95), (0.16, 1.0),
               (0.11, 1.08), (0.1, 1.14), (0.2, 1.17)]
    profile += arc(0.2, 1.62, 0.62 * 0.726, -90, -24, 10)[1:]
    rim = profile[-1]
    profile += [(rim[0] + 0.04, rim[1] + 0.01), (rim[0] + 0.045, rim[1] + 0.05), (rim[0], rim[1] + 0.055), (0.3, 1.29), (0.1, 1.26),
                (0.07, 1.32), (0.06, 1.5), (0.09, 1.53), (0.09, 1.55), (0.05, 1.58), (0.075, 1.64), (0.085, 1.7), (0.06, 1.77), (0, 1.81)]
    return [(basin, "stone", 1.0), (m.lathe(profile, 48), "stone", 1.0)]


def water():
    return [(m.lathe([(0, 0.3), (1.26, 0.3), (1.26, 0.42), (0, 0.42)], 8).turned("y", 22.5) +
             m.lathe([(0, 1.28), (0.5, 1.3), (0.5, 1.41), (0, 1.41)], 32), "water", 0.5)]


def pot(radius, height):
    r = radius
    profile = [(0, 0), (0.62 * r, 0), (0.64 * r, 0.02), (0.72 * r, 0.25 * height), (0.9 * r, 0.72 * height), (0.92 * r, 0.8 * height),
               (r, 0.82 * height), (1.03 * r, 0.88 * height), (1.03 * r, 0.95 * height), (r, height), (0.88 * r, height),
               (0.85 * r, 0.9 * height), (0, 0.9 * height)]
    return [(m.lathe(profile, 32), "terracotta", 1.0)]


def ball_of_leaves(radius, count, seed, size, center=(0, 0, 0), squash=1.0):
    """Open cards on a ball's shell and in it, facing roughly outwards."""
    rng = random.Random(seed)
    leaves = Mesh()
    for _ in range(count):
        z, a = rng.uniform(-1, 1), rng.uniform(0, 2 * math.pi)
        s = math.sqrt(1 - z * z)
        out = (s * math.cos(a), z, s * math.sin(a))
        r = radius * rng.uniform(0.55, 1.0) ** 0.6
        facing = m.normalize(m.add(out, (rng.uniform(-0.7, 0.7), rng.uniform(-0.3, 0.9), rng.uniform(-0.7, 0.7))))
        up = m.normalize((rng.uniform(-1, 1), rng.uniform(0.1, 1.2), rng.uniform(-1, 1)))
        if abs(m.dot(up, facing)) > 0.95:
            continue
        place = m.add(center, (out[0] * r, out[1] * r * squash, out[2] * r))
        w = size * rng.uniform(0.8, 1.25)
        leaves += m.card(place, facing, up, w, w * 1.25, (0.14, 0.0, 0.86, 0.98))
    return leaves


def tree(seed):
    """Olive: bent trunk, five limbs, a crown of cards. Trunk and crown apart: the crown is open geometry."""
    rng = random.Random(seed)
    trunk = [(0, -0.1, 0), (0.03, 0.35, 0.02), (-0.05, 0.8, 0.05), (0.04, 1.25, -0.02), (0.0, 1.65, 0.02)]
    bark = m.tube(trunk, [0.15, 0.115, 0.1, 0.1, 0.085], 14)
    crown = Mesh()
    for i in range(6):
        a = 2 * math.pi * i / 6 + rng.uniform(-0.3, 0.3)
        reach, rise = rng.uniform(0.65, 0.95), rng.uniform(0.6, 1.15)
        end = (reach * math.cos(a), 1.55 + rise, reach * math.sin(a))
        middle = (end[0] * 0.45, 1.55 + rise * 0.65, end[2] * 0.45)
        bark += m.tube([(0, 1.5, 0), middle, end], [0.07, 0.045, 0.02], 9)
        crown += ball_of_leaves(rng.uniform(0.6, 0.74), 190, seed + i, 0.27, end, 0.8)
    crown += ball_of_leaves(0.75, 190, seed + 9, 0.27, (0, 2.75, 0), 0.75)
    return [(bark, "wood", 0.8)], [(crown, "olive", 1.0)]


def vine(length, seed):
    """Blossom spilling over a cornice along x: denser above, trailing down."""
    rng = random.Random(seed)
    leaves, bloom = Mesh(), Mesh()
    for i in range(int(150 * length)):
        x = rng.uniform(-length / 2, length / 2)
        edge = 1 - (2 * x / length) ** 2
        drop = rng.random() ** 1.6 * (0.25 + 1.25 * edge * (0.55 + 0.45 * math.sin(3.1 * x + 1.0)))
        out = 0.1 + 0.28 * math.exp(-2.5 * drop) * rng.random() ** 0.7
        facing = m.normalize((rng.uniform(-0.7, 0.7), rng.uniform(-0.2, 0.8), 1.0))
        up = m.normalize((rng.uniform(-0.8, 0.8), rng.uniform(-1.0, 0.6), 0.2))
        w = rng.uniform(0.17, 0.27)
        piece = m.card((x, 0.12 - drop + 0.12 * rng.random(), out), facing, up, w, w * 1.2, (0.14, 0.0, 0.86, 0.98))
        if rng.random() < 0.62:
            bloom += piece
        else:
            leaves += piece
    return [(leaves, "leaf", 1.0), (bloom, "bloom", 1.0)]


def lantern():
    """Open cage hung from a chain; the light's place is the origin. Nothing closes it in, so its bars draw on the walls."""
    iron = m.lathe([(0, 0.14), (0.15, 0.12), (0.155, 0.14), (0.03, 0.25), (0.02, 0.29), (0, 0.29)], 6).turned("y", 30)
    iron += m.lathe([(0, -0.2), (0.1, -0.2), (0.1, -0.185), (0, -0.185)], 6).turned("y", 30)
    for i in range(6):
        a = math.radians(60 * i + 30)
        c, s = math.cos(a), math.sin(a)
        iron += m.bar((0.09 * c, -0.192, 0.09 * s), (0.13 * c, 0.128, 0.13 * s), 0.006, 6)
    iron += m.bar((0, 0.285, 0), (0, 0.95, 0), 0.008, 6)
    candle = m.lathe([(0, -0.187), (0.022, -0.187), (0.022, -0.1), (0, -0.095)], 12)
    return [(iron, "iron", 1.0), (candle, "wax", 1.0)]


def spot_bracket():
    """Arm from a wall at z = 0 to a lamp; the light sits just outside the hood's mouth, at the origin of the hood's own
    mesh (see spot_hood); the arm ends 0.12 m above (0, 0, 0.7)."""
    iron = m.bevel_box(0.12, 0.24, 0.05, 0.01).moved(0, 0.02, 0.0)
    iron += m.bar((0, 0.14, 0.0), (0, 0.14, 0.72), 0.018, 10) + m.bar((0, -0.06 + 0.12, 0.01), (0, 0.135, 0.42), 0.012, 8)
    iron += m.bar((0, 0.15, 0.7), (0, 0.05, 0.7), 0.014, 8)
    return [(iron, "iron", 1.0)]


def spot_hood():
    """Lamp hood open along -Z; its mouth is at z = 0.02, the light at the origin outside it."""
    hood = m.lathe([(0, 0.20), (0.045, 0.195), (0.06, 0.17), (0.085, 0.02), (0.078, 0.02), (0.054, 0.16), (0, 0.165)][::-1], 28)
    return [(hood.turned("x", 90), "iron", 1.0)]


def door():
    """Two leaves of boards, 1.2 × 2.34 m, with straps and rings; stands in its opening, facing +z."""
    leaf = m.box(-0.63, -0.03, -0.06, 0.63, 2.37, 0.0)
    iron = Mesh()
    for side in (-1, 1):
        for y in (0.35, 1.95):
            iron += m.bevel_box(0.44, 0.05, 0.03, 0.006).moved(side * 0.36, y, 0.0)
        iron += m.sweep([(0.009 * math.cos(a), 0.009 * math.sin(a)) for a in [2 * math.pi * i / 8 for i in range(8)]],
                        [((side * 0.1 + 0.05 * math.cos(t), 1.08 + 0.05 * math.sin(t), 0.012), (math.cos(t), math.sin(t), 0), (0, 0, 1))
                         for t in [2 * math.pi * i / 20 for i in range(20)]], closed=True)
    seam = m.bevel_box(0.05, 2.3, 0.03, 0.008).moved(0, 0.02, 0.0)
    return [(leaf, "wood", 1.25), (seam, "wood", 1.25), (iron, "iron", 1.0)]


def frame(width, height, face=0.2, proud=0.07, sill=False):
    """Stone surround of an opening whose lower middle is the origin, standing `proud` of the wall at z = 0."""
    depth = proud + 0.04
    def piece(sx, sy, x, y, more=0.0):
        return m.bevel_box(sx, sy, depth + more, 0.012).moved(x, y, (depth + more) / 2 - 0.04)
    solid = Mesh()
    for side in (-1, 1):
        solid += piece(face, height + (0.0 if sill else 0.1), side * (width + face - 0.02) / 2, 0.0 if sill else -0.1)
    solid += piece(width + 2 * face + 0.06, face, 0, height - 0.01, 0.012)
    solid += piece(width + 2 * face + 0.14, 0.07, 0, height + face - 0.02, 0.05)
    if sill:
        solid += piece(width + 2 * face + 0.1, 0.11, 0, -0.1, 0.09)
    return [(solid, "stone", 1.0)]


def window_bars(width, height):
    """Casement frame with one mullion and two transoms, in the opening (origin: lower middle); reaches into the reveals."""
    solid = Mesh()
    for x in (-width / 2 + 0.02, 0.0, width / 2 - 0.02):
        solid += m.bevel_box(0.07, height + 0.04, 0.07, 0.01).moved(x, -0.02, 0)
    for y in (-0.02, height * 0.62, height - 0.05):
        solid += m.bevel_box(width + 0.04, 0.06, 0.055, 0.01).moved(0, y, 0)
    return [(solid, "wood", 1.25)]


def shutter(width, height):
    """Louvred leaf, its back on z = 0, lower middle at the origin."""
    solid = Mesh()
    for x in (-width / 2 + 0.035, width / 2 - 0.035):
        solid += m.bevel_box(0.07, height, 0.05, 0.008).moved(x, 0, 0.025)
    for y in (0, height / 2 - 0.035, height - 0.07):
        solid += m.bevel_box(width - 0.12, 0.07, 0.044, 0.008).moved(0, y, 0.025)
    count = int(height / 0.075)
    for i in range(1, count):
        y = i * height / count
        if abs(y - height / 2) > 0.06 and y < height - 0.1:
            solid += m.box(-width / 2 + 0.06, -0.028, -0.006, width / 2 - 0.06, 0.028, 0.006).turned("x", -35).moved(0, y, 0.025)
    return [(solid, "shutter", 1.0)]


def roof_tiles(columns, rows, pitch):
    """Barrel tiles on a slope that rises along -z from the origin's line; `pitch` metres per tile along the slope."""
    solid, step, segments = Mesh(), 0.26, 6
    for row in range(rows):
        for column_ in range(columns):
            ra, rb = 0.118, 0.1  # wider at its lower end, which lies over the tile below
            length = pitch * 1.12
            frames = []
            for t, r, lift in ((0.0, ra, 0.028), (1.0, rb, 0.0)):
                frames.append((((column_ + 0.5 - columns / 2) * step, lift, -row * pitch - t * length), (r, 0, 0), (0, r, 0)))
            profile = arc(0, 0, 1.0, 0, 180, segments)
            solid += m.sweep(profile, frames)
    return [(solid, "terracotta", 1.0)]


def bench():
    solid = m.bevel_box(1.5, 0.09, 0.42, 0.015).moved(0, 0.4, 0)
    for x in (-0.55, 0.55):
        solid += m.bevel_box(0.14, 0.42, 0.34, 0.02).moved(x, -0.01, 0)
    return [(solid, "stone", 1.0)]


def crate(size):
    """Boarded box with a frame around each side."""
    solid, t = m.bevel_box(size - 0.04, size - 0.04, size - 0.04, 0.005).moved(0, 0.02, 0), 0.09 * size + 0.02
    h = size / 2 - t / 2
    for a in (-h, h):
        for b in (-h, h):
            solid += m.bevel_box(t, size, t, 0.006).moved(a, 0, b)
            solid += m.bevel_box(size - 1.6 * t, t, t, 0.006).moved(0, b + h, a) + m.bevel_box(t, t, size - 1.6 * t, 0.006).moved(b, a + h, 0)
    return [(solid, "crate", 1.6)]


def barrel():
    profile = [(0, 0)] + [(0.24 + 0.075 * math.sin(math.pi * i / 10), 0.88 * i / 10) for i in range(11)] + \
              [(0.21, 0.88), (0.21, 0.85), (0, 0.85)]
    hoops = Mesh()
    for y in (0.1, 0.3, 0.58, 0.78):
        r = 0.24 + 0.075 * math.sin(math.pi * y / 0.88)
        hoops += m.sweep([(-0.02, -0.022), (0.008, -0.022), (0.008, 0.022), (-0.02, 0.022)],
                         [((r * math.cos(a), y, r * math.sin(a)), (math.cos(a), 0, math.sin(a)), (0, 1, 0))
                          for a in [2 * math.pi * i / 32 for i in range(32)]], closed=True)
    return [(m.lathe(profile, 32, 1.25), "wood", 1.25), (hoops, "iron", 1.0)]


def table(length, depth, height):
    solid = m.bevel_box(length, 0.06, depth, 0.01).moved(0, height - 0.06, 0)
    solid += m.bevel_box(length - 0.16, 0.09, depth - 0.16, 0.006).moved(0, height - 0.145, 0)
    for x in (-1, 1):
        for z in (-1, 1):
            solid += m.bevel_box(0.08, height - 0.05, 0.08, 0.01).moved(x * (length / 2 - 0.1), 0, z * (depth / 2 - 0.1))
    return [(solid, "crate", 1.25)]


# ---------------------------------------------------------------------------------------------------------------------
# Dynamic objects


def torus_knot(p, q, major, minor, radius, steps=180, segments=14):
    points = []
    for i in range(steps):
        t = 2 * math.pi * i / steps
        r = major + minor * math.cos(q * t)
        points.append((r * math.cos(p * t), minor * 1.15 * math.sin(q * t), r * math.sin(p * t)))
    low = min(y for _, y, _ in points) - radius
    return m.tube([(x, y - low, z) for x, y, z in points], [radius] * steps, segments, closed=True)


def torus(major, minor, segments=64, sides=24):
    circle = [(minor * math.cos(2 * math.pi * i / sides), minor * math.sin(2 * math.pi * i / sides)) for i in range(sides)]
    frames = [((major * math.cos(a), major * math.sin(a), 0), (math.cos(a), math.sin(a), 0), (0, 0, 1))
              for a in [2 * math.pi * i / segments for i in range(segments)]]
    return m.sweep(circle, frames, closed=True)


def figure():
    """A draughtsman's lay figure in a long coat, 1.72 m: turned body, ball head, jointed arms."""
    body = [(0, 0), (0.2, 0), (0.245, 0.02), (0.25, 0.05), (0.21, 0.3), (0.165, 0.7), (0.14, 0.98), (0.15, 1.1), (0.185, 1.26),
            (0.19, 1.33), (0.16, 1.39), (0.09, 1.425), (0.052, 1.44), (0.048, 1.49), (0, 1.5)]
    head = m.sphere(0.118, 36, 20).scaled(0.92, 1.16, 1.0).moved(0, 1.585, 0.01)
    arms = Mesh()
    for side, hand in ((-1, (-0.27, 0.86, 0.12)), (1, (0.42, 1.12, 0.26))):
        shoulder, elbow = (side * 0.19, 1.31, 0.0), (side * 0.31, 1.07, 0.0)
        arms += m.tube([shoulder, m.mul(m.add(shoulder, elbow), 0.5), elbow], [0.055, 0.052, 0.042], 16)
        arms += m.tube([elbow, m.mul(m.add(elbow, hand), 0.5), hand], [0.042, 0.04, 0.028], 16)
        arms += m.sphere(0.06, 20, 12).moved(*shoulder) + m.sphere(0.045, 20, 12).moved(*elbow) + m.sphere(0.048, 20, 12).moved(*hand)
    return m.lathe(body, 48) + head + arms


def teapot():
    """Turned pot with lid, spout and handle; 0.3 m wide."""
    body = [(0, 0), (0.07, 0), (0.072, 0.008), (0.095, 0.02), (0.125, 0.055), (0.135, 0.09), (0.125, 0.13), (0.098, 0.16), (0.075, 0.172),
            (0.078, 0.18), (0.05, 0.195), (0.02, 0.203), (0.012, 0.21), (0.02, 0.222), (0.02, 0.232), (0.01, 0.24), (0, 0.241)]
    spout = m.tube([(0.1, 0.06, 0), (0.155, 0.075, 0), (0.185, 0.12, 0), (0.225, 0.165, 0)], [0.032, 0.024, 0.017, 0.014], 16)
    handle = m.tube([(-0.1, 0.14, 0), (-0.16, 0.16, 0), (-0.2, 0.13, 0), (-0.185, 0.08, 0), (-0.12, 0.05, 0)], [0.011] * 5, 12)
    return m.lathe(body, 40) + spout + handle
