"""Furniture of the chapel, each a list of (Mesh, material, texture repeats per metre), as in parts.py."""

import math

from . import gothic, mesh as m, parts
from .mesh import Mesh


def pew():
    """Bench with a sloped back and carved ends, facing -z, 1.5 m long."""
    solid = m.bevel_box(1.46, 0.05, 0.38, 0.012).moved(0, 0.42, 0)
    solid += m.bevel_box(1.46, 0.5, 0.04, 0.012).turned("x", 8).moved(0, 0.45, 0.2) + m.bevel_box(1.46, 0.06, 0.09, 0.02).moved(0, 0.92, 0.27)
    solid += m.bevel_box(1.46, 0.3, 0.03, 0.008).moved(0, 0.1, 0.1) + m.bevel_box(1.46, 0.03, 0.16, 0.008).moved(0, 0.14, 0.36)
    end = [(-0.24, 0), (0.34, 0), (0.34, 0.1), (0.3, 0.16), (0.34, 0.94), (0.33, 1.02), (0.27, 1.06), (0.2, 1.04), (0.17, 0.95), (0.12, 0.66), (0.04, 0.56),
           (-0.14, 0.55), (-0.22, 0.5), (-0.24, 0.42), (-0.2, 0.16), (-0.24, 0.1)]
    for x in (-0.75, 0.75):
        solid += m.sweep(end, [((x + t, 0, 0), (0, 0, 1), (0, 1, 0)) for t in (-0.03, 0.03)])
    return [(solid, "wood", 1.25)]


def stall():
    """Choir stall of three seats with a panelled back under pointed arches, facing +z, 2.1 m long."""
    solid = m.bevel_box(2.1, 0.06, 0.45, 0.012).moved(0, 0.44, 0.2) + m.bevel_box(2.1, 2.0, 0.06, 0.01).moved(0, 0, -0.05)
    solid += m.bevel_box(2.2, 0.1, 0.3, 0.03).moved(0, 2.0, 0.05)
    for i in range(4):
        x = (i - 1.5) * 0.69
        solid += m.bevel_box(0.06, 0.72, 0.5, 0.015).moved(x, 0, 0.18) + m.bevel_box(0.08, 0.05, 0.42, 0.015).moved(x, 0.72, 0.18)
        if i < 3:
            arch = gothic.outline(0.95, 1.55, 0.26, 0.4)
            solid += gothic.trim(arch, gothic.rectangle(-0.02, 0.04, -0.03, 0.03, 0.01)).moved(x + 0.345, 0, 0)
    return [(solid, "wood", 1.25)]


def station():
    """Framed relief for a wall at z = 0: a figure under a small gable."""
    frame = gothic.trim(gothic.outline(0.0, 0.45, 0.24, 0.34), gothic.rectangle(-0.02, 0.05, -0.02, 0.06, 0.015))
    points = gothic.outline(0.0, 0.45, 0.24, 0.34)
    board = m.sweep(points, [((0, 0, z), (1, 0, 0), (0, 1, 0)) for z in (-0.03, 0.015)])
    figure = m.lathe([(0, 0.04), (0.1, 0.04), (0.085, 0.2), (0.06, 0.36), (0.03, 0.4), (0, 0.4)], 16).scaled(1, 1, 0.5)
    figure += m.sphere(0.05, 14, 10).scaled(1, 1.2, 0.7).moved(0, 0.46, 0.01)
    return [(frame, "oak", 1.25), (board, "azure", 1.0), (figure, "gold", 1.0)]


def banner():
    """Cloth that hangs from a rod, its folds along x, 0.7 by 1.9 m; the rod's middle is the origin."""
    steps, thick = 24, 0.012
    path = [((i / steps - 0.5) * 0.7, 0.035 * math.sin(i / steps * math.tau * 2.5)) for i in range(steps + 1)]
    outline = [(x, z - thick) for x, z in path] + [(x, z + thick) for x, z in reversed(path)]
    cloth = m.sweep(outline, [((0, y, 0), (1, 0, 0), (0, 0, 1)) for y in (-1.9, 0.02)])
    rod = m.bar((-0.42, 0.03, 0), (0.42, 0.03, 0), 0.016, 10)
    for x in (-0.42, 0.42):
        rod += m.sphere(0.035, 14, 10).moved(x, 0.03, 0)
    stripe = m.bevel_box(0.12, 1.0, 0.1, 0.004).moved(0, -1.3, 0) + m.bevel_box(0.44, 0.12, 0.1, 0.004).moved(0, -0.72, 0)
    return [(Mesh([(t, None) for t, _ in cloth.triangles]), "carpet", 1.0), (rod, "gold", 1.0), (stripe, "linen", 1.0)]


def candle_rack():
    """Iron stand with three rows of votive candles."""
    iron = Mesh()
    for x in (-0.4, 0.4):
        iron += m.bar((x, 0, 0.2), (x, 0.95, -0.12), 0.014, 8) + m.bar((x, 0, -0.2), (x, 0.7, 0.1), 0.014, 8)
    wax = Mesh()
    for row in range(3):
        y, z = 0.78 + 0.1 * row, 0.14 - 0.13 * row
        iron += m.bevel_box(0.92, 0.02, 0.1, 0.005).moved(0, y, z)
        for i in range(7):
            wax += m.cylinder(0.02, 0.07 + 0.03 * ((i * 5 + row * 3) % 4), 12, 0.004).moved((i - 3) * 0.125, y + 0.015, z)
    return [(iron, "iron", 1.0), (wax, "wax", 1.0)]


def boss():
    """Carved stone where ribs meet, hanging below the origin."""
    solid = m.lathe([(0, -0.16), (0.06, -0.15), (0.14, -0.08), (0.19, 0.02), (0.19, 0.12), (0, 0.12)], 24)
    return [(solid + gothic.leaf_ring(0.15, 10, -0.05).scaled(1, 0.7, 1), "stone", 1.0)]


def books():
    """A row of hymn books on a pew's shelf."""
    solid = Mesh()
    for i, (x, lean) in enumerate(((-0.5, 4), (-0.46, 0), (-0.1, -6), (0.38, 2), (0.42, 7))):
        solid += m.bevel_box(0.03, 0.19 + 0.01 * (i % 3), 0.13, 0.004).turned("z", lean).moved(x, 0.165, 0.36)
    return [(solid, "book", 1.0)]


def statue():
    """Saint on a corbel, its back to a wall at z = 0."""
    corbel = m.lathe([(0, 0), (0.05, 0), (0.1, 0.12), (0.2, 0.26), (0.22, 0.3), (0.22, 0.36), (0, 0.36)], 20)
    body = m.lathe([(0, 0.36), (0.2, 0.36), (0.19, 0.5), (0.15, 0.9), (0.17, 1.15), (0.15, 1.22), (0.06, 1.27), (0.05, 1.32), (0, 1.32)], 28)
    head = m.sphere(0.095, 24, 16).scaled(0.9, 1.15, 1).moved(0, 1.4, 0.01)
    arms = m.tube([(-0.17, 1.14, 0), (-0.2, 0.95, 0.1), (-0.02, 0.98, 0.2)], [0.045, 0.04, 0.03], 12)
    arms += m.tube([(0.17, 1.14, 0), (0.2, 0.95, 0.1), (0.02, 1.0, 0.2)], [0.045, 0.04, 0.03], 12)
    halo = gothic.trim(parts.arc(0, 1.42, 0.15, 0, 360, 24)[:-1], gothic.rectangle(-0.012, 0.012, -0.07, -0.05))
    return [((corbel + body + head + arms).moved(0, 0, 0.2), "stone", 1.0), (halo.moved(0, 0, 0.2), "gold", 1.0)]
