#!/usr/bin/env python3
"""Makes the scenes of docs/quality.md in assets/quality/: each is named after the artifact that it would show.

    scripts/make_quality_scenes.py [FOLDER]

X east, Y up, metres. bench/quality.cpp measures their bakes and knows the right answers; assets/README.md lists them.
"""

import math

from scenekit import gltf, mesh as m
from scenekit.mesh import Mesh

BAKED = {"halflight_mode": "baked"}
MIXED = {"halflight_mode": "mixed"}
NO_TEXELS = {"halflight_lightmap_scale": 0}

COLORS = {"grey": (0.5, 0.5, 0.5), "white": (0.8, 0.8, 0.8), "red": (0.6, 0.1, 0.08), "black": (0.0, 0.0, 0.0)}


def document(name, materials, sky=None):
    doc = gltf.Document("Halflight scripts/make_quality_scenes.py")
    doc.json["scenes"][0]["name"] = name
    for material in materials:
        doc.material(material, COLORS[material], 1.0)
    if sky is not None:
        doc.json["scenes"][0]["extras"] = {f"halflight_sky_{part}": list(color) for part, color in zip(("zenith", "horizon", "ground"), sky)}
    return doc


def plate(points, thickness):
    """A flat solid: the polygon in x and z, its upper side at y = 0."""
    frames = [((0.0, -thickness, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))]
    return m.sweep(points, frames)


def sheet(x0, z0, x1, z1):
    """One rectangle that faces up, at y = 0."""
    mesh = Mesh()
    mesh.quad((x0, 0, z1), (x1, 0, z1), (x1, 0, z0), (x0, 0, z0))
    return mesh


def leaks():
    """A room put together of six boards 2 cm thick, under a sky of 50 nits on all sides. Boards overlap by a centimetre, as built
    by hand. Inside: a box on the floor, two boxes in one another, a ball sunk a little into the floor, a carpet (one sheet, single-sided) 1 cm
    above the floor, a picture (double-sided sheet) 5 mm off a wall. Nothing lights the inside: all light in there is leaked."""
    doc = document("leaks", ("white", "grey", "red"), ((50.0, 50.0, 50.0),) * 3)
    doc.material("picture", COLORS["grey"], 1.0, double_sided=True)
    w, h, d, t = 2.0, 2.4, 1.6, 0.02  # half width, height, half depth, thickness
    boards = {"floor": (-w - 0.01, -t, -d - 0.01, w + 0.01, 0.0, d + 0.01), "ceiling": (-w - 0.01, h, -d - 0.01, w + 0.01, h + t, d + 0.01),
              "west": (-w - t, -0.01, -d - 0.01, -w, h + 0.01, d + 0.01), "east": (w, -0.01, -d - 0.01, w + t, h + 0.01, d + 0.01),
              "north": (-w - 0.01, -0.01, -d - t, w + 0.01, h + 0.01, -d), "south": (-w - 0.01, -0.01, d, w + 0.01, h + 0.01, d + t)}
    for name, bounds in boards.items():
        doc.mesh(name, [(m.box(*bounds), "white", 1.0)])
        doc.node(f"board_{name}", name)
    doc.mesh("box", [(m.box(-0.3, 0.0, -0.3, 0.3, 0.6, 0.3), "grey", 1.0)])
    doc.mesh("ball", [(m.sphere(0.3, 24, 12), "red", 1.0)])
    doc.mesh("carpet", [(sheet(-0.6, -0.4, 0.6, 0.4), "red", 1.0)], closed=False)
    doc.mesh("picture", [(sheet(-0.4, -0.3, 0.4, 0.3), "picture", 1.0)], closed=False)
    doc.node("box_on_floor", "box", (-1.3, 0.0, -0.9), 15)
    doc.node("box_a", "box", (1.1, 0.0, -0.8), 10)
    doc.node("box_b", "box", (1.35, 0.25, -0.65), 40)
    doc.node("ball_in_floor", "ball", (0.0, 0.285, -1.0))
    doc.node("carpet", "carpet", (0.0, 0.01, 0.6))
    doc.node("picture", "picture", (-0.2, 1.4, -1.595), rotation=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    doc.camera("main", (1.7, 1.7, 1.4), (-0.4, 0.4, -0.7), 65)
    return doc


def tilted(mesh, along_x, along_z):
    """The mesh raised by along_x and along_z metres per metre."""
    return Mesh([(tuple((x, y + along_x * x + along_z * z, z) for x, y, z in corners), uv) for corners, uv in mesh.triangles])


def cellars():
    """Walls that go on below a floor, which is a board 2 cm thick or a double-sided sheet. Floors tilt, so that they cross the walls'
    texels at all heights. Two dark closed rooms have a lit cellar below. Two black walls stand in the sun, and what lies below their
    floor is in the dark; nothing is reflected onto them."""
    doc = document("cellars", ("grey", "black"), ((0.0, 0.0, 0.0),) * 3)
    doc.material("grey_sheet", COLORS["grey"], 1.0, double_sided=True)
    doc.material("black_sheet", COLORS["black"], 1.0, double_sided=True)
    w, d, low, high, t = 0.7, 0.5, -0.7, 1.7, 0.1  # half width, half depth, lower and upper end, thickness
    boards = {"bottom": (-w - t, low - t, -d - t, w + t, low, d + t), "ceiling": (-w - t, high, -d - t, w + t, high + t, d + t),
              "west": (-w - t, low - 0.01, -d - t, -w, high + 0.01, d + t), "east": (w, low - 0.01, -d - t, w + t, high + 0.01, d + t),
              "north": (-w - 0.01, low - 0.01, -d - t, w + 0.01, high + 0.01, -d), "south": (-w - 0.01, low - 0.01, d, w + 0.01, high + 0.01, d + t)}
    for name, bounds in boards.items():
        doc.mesh(name, [(m.box(*bounds), "grey", 1.0)])
    doc.mesh("wall", [(m.box(-w, low, -t, w, high, 0.0), "black", 1.0)])
    for color, floor in (("grey", (-w - 0.02, -d - 0.02, w + 0.02, d + 0.02)), ("black", (-w - 0.02, -0.02, w + 0.02, 2 * d))):
        x0, z0, x1, z1 = floor
        doc.mesh(f"{color}_board", [(tilted(m.box(x0, -0.02, z0, x1, 0.0, z1), 0.1, 0.08), color, 1.0)])
        doc.mesh(f"{color}_sheet", [(tilted(sheet(x0, z0, x1, z1), 0.1, 0.08), f"{color}_sheet", 1.0)], closed=False)
    for i, kind in enumerate(("board", "sheet")):
        x = 3.0 * i
        for name in boards:
            doc.node(f"{name}_{i}", name, (x, 0, -3))
        doc.node(f"floor_{i}", f"grey_{kind}", (x, 0, -3))
        doc.light(f"cellar_{i}", "point", (1, 1, 1), 10.0, (x, -0.4, -3), extras=dict(BAKED))
        doc.node(f"wall_{i}", "wall", (x, 0, 0))
        doc.node(f"yard_{i}", f"black_{kind}", (x, 0, 0))
    for name, how in (("sun", BAKED), ("mixed_sun", MIXED)):
        doc.light(name, "directional", (1, 1, 1), 10.0, (0, 10, 10), (0, 0, 0), extras={**how, "halflight_angular_diameter": 0.0})
    doc.camera("main", (1.5, 1.6, 3.2), (1.5, 0.5, 0.0), 60)
    return doc


def rims():
    """Plates of awkward outlines, turned by awkward angles, some a few texels wide, under a fully baked sun straight above: tops
    have its light, to the last texel and whatever the filter, undersides none, and the two lie side by side in the lightmap."""
    doc = document("rims", ("grey",), ((0.0, 0.0, 0.0),) * 3)
    star = [((0.5 if i % 2 == 0 else 0.18) * math.cos(i * math.pi / 7), (0.5 if i % 2 == 0 else 0.18) * math.sin(i * math.pi / 7)) for i in range(14)]
    disc = [(0.45 * math.cos(i * math.pi / 16), 0.45 * math.sin(i * math.pi / 16)) for i in range(32)]
    wedge = [(-0.6, 0.0), (0.6, -0.2), (0.6, 0.2)]
    comb = [(-0.5, -0.4), (0.5, -0.4)] + [p for i in range(5) for p in ((0.5 - 0.2 * i, 0.4), (0.42 - 0.2 * i, 0.4), (0.42 - 0.2 * i, -0.3), (0.3 - 0.2 * i, -0.3))]
    comb = comb[:-2] + [(-0.5, -0.3)]
    for name, outline in (("star", star), ("disc", disc), ("wedge", wedge), ("comb", comb)):
        doc.mesh(name, [(plate(outline, 0.02), "grey", 1.0)])
    for i in range(20):
        name = ("star", "disc", "wedge", "comb")[i % 4]
        doc.node(f"{name}_{i}", name, (1.3 * (i % 5), 0.0, 1.3 * (i // 5)), 17.0 * i + 5.0, scale=(1.0, 0.6, 1.3, 0.45, 0.3)[i // 4])
    doc.light("sun", "directional", (1, 1, 1), 10.0, (0, 10, 0), (0, 0, 0), extras=dict(BAKED))
    doc.camera("main", (2.6, 4.0, 5.5), (2.6, 0.0, 1.8), 50)
    return doc


def seams():
    """A ball, a can and a chamfered box, and a floor of nine tiles that meet (one of them cut finer than its neighbours), under a sky
    and a low sun with a soft edge: smooth light across every seam."""
    doc = document("seams", ("white", "red", "grey"), ((2.0, 3.0, 5.0), (4.0, 4.0, 4.0), (0.5, 0.5, 0.5)))
    fine = Mesh()
    for i in range(4):
        for j in range(4):
            x, z = -1 + 0.5 * i, -1 + 0.5 * j
            fine.quad((x, 0, z + 0.5), (x + 0.5, 0, z + 0.5), (x + 0.5, 0, z), (x, 0, z))
    doc.mesh("tile", [(sheet(-1, -1, 1, 1), "white", 1.0)], closed=False)
    doc.mesh("tile_fine", [(fine, "white", 1.0)], closed=False)
    doc.mesh("ball", [(m.sphere(0.5, 32, 16), "red", 1.0)])
    doc.mesh("can", [(m.cylinder(0.4, 1.0, 32), "grey", 1.0)])
    doc.mesh("chamfered", [(m.bevel_box(0.8, 0.8, 0.8, 0.08), "grey", 1.0)], crease=60.0)
    for i in range(9):
        doc.node(f"tile_{i}", "tile_fine" if i == 4 else "tile", (2.0 * (i % 3 - 1), 0.0, 2.0 * (i // 3 - 1)))
    doc.node("ball", "ball", (-1.2, 0.7, 0.3))
    doc.node("can", "can", (0.2, 0.05, -0.4))
    doc.node("chamfered", "chamfered", (1.5, 0.05, 0.5), 25)
    doc.light("sun", "directional", (1, 0.9, 0.8), 20.0, (-6, 5, 3), (0, 0, 0), extras={**BAKED, "halflight_angular_diameter": 12.0})
    doc.camera("main", (0.4, 2.3, 4.2), (0.2, 0.4, -0.1), 50)
    return doc


def curtain():
    """A curtain of two sheets whose normals run smoothly round its hems, as modellers' do, one side in the sun: the other has no light,
    up to the hem, however its charts are stitched."""
    doc = document("curtain", ("grey",), ((0.0, 0.0, 0.0),) * 3)
    cloth = Mesh()
    n, thick = 24, 0.01
    xs = [-1.0 + 2.0 * i / n for i in range(n + 1)]
    front = [(x, 0.06 * math.sin(9.0 * x) + thick) for x in xs]
    back = [(x, 0.06 * math.sin(9.0 * x) - thick) for x in xs]
    around = front + back[::-1]
    for (x0, z0), (x1, z1) in zip(around, around[1:] + around[:1]):
        for y in (0.0, 0.8):
            cloth.quad((x0, y, z0), (x1, y, z1), (x1, y + 0.8, z1), (x0, y + 0.8, z0))
    for (x0, f0), (x1, f1), (_, b0), (_, b1) in zip(front, front[1:], back, back[1:]):
        cloth.quad((x0, 1.6, f0), (x1, 1.6, f1), (x1, 1.6, b1), (x0, 1.6, b0))
        cloth.quad((x0, 0.0, b0), (x1, 0.0, b1), (x1, 0.0, f1), (x0, 0.0, f0))
    doc.mesh("curtain", [(cloth, "grey", 1.0)], crease=180.0)
    doc.node("curtain", "curtain")
    doc.light("sun", "directional", (1, 1, 1), 10.0, (0, 0, 10), (0, 0, 0), extras=dict(BAKED))
    doc.camera("main", (-1.3, 1.5, 1.9), (0.0, 0.75, 0.0), 50)
    return doc


def mask_edges():
    """A floor under a board with a straight edge that runs askew to the texels, and an upright round hole's worth of teeth; a sun without
    extent straight above: the mask is the board's outline, antialiased."""
    doc = document("mask_edges", ("white", "grey"))
    doc.mesh("floor", [(m.box(-2, -0.1, -2, 2, 0, 2), "white", 1.0)])
    outline = [(-1.2, -0.9), (0.9, -1.1), (1.1, 0.2), (0.3, 0.35), (0.35, 1.1), (-1.0, 0.8)]
    doc.mesh("board", [(plate(outline, 0.01), "grey", 1.0)])
    doc.node("floor", "floor")
    doc.node("board", "board", (0, 1.0, 0), extras=dict(NO_TEXELS))
    doc.light("sun", "directional", (1, 1, 1), math.pi, (0, 10, 0), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 0.0})
    doc.camera("main", (0.0, 2.8, 2.6), (0.0, 0.0, 0.1), 50)
    return doc


def terminator():
    """Round things of few triangles under a low sun, each by itself in the air, and a floor that the sun grazes at 1.5 degrees: none shadows
    itself before its smooth surface turns away."""
    doc = document("terminator", ("white", "red"))
    doc.mesh("floor", [(m.box(-4, -0.1, -4, 4, 0, 4), "white", 1.0)])
    doc.mesh("ball_12", [(m.sphere(0.5, 12, 6), "red", 1.0)], crease=60.0)
    doc.mesh("ball_20", [(m.sphere(0.5, 20, 10), "red", 1.0)], crease=60.0)
    doc.mesh("can_10", [(m.cylinder(0.4, 1.0, 10), "red", 1.0)], crease=50.0)
    doc.node("floor", "floor", (0, -3, 0))
    doc.node("ball_12", "ball_12", (-4.0, 1.0, 0))
    doc.node("ball_20", "ball_20", (0.0, 1.0, -4.0))
    doc.node("can_10", "can_10", (4.0, 0.5, 4.0))
    elevation = math.radians(1.5)
    doc.light("sun", "directional", (1, 1, 1), math.pi, (10 * math.cos(elevation), 10 * math.sin(elevation), 2), (0, 0, 2), extras={**MIXED, "halflight_angular_diameter": 0.53})
    doc.camera("main", (-2.2, 1.6, 2.6), (-4.0, 1.0, 0), 45)
    return doc


def contact():
    """A closed room lit by its ceiling's panel, with boxes on its floor: soft light, and dark contact under what stands."""
    doc = document("contact", ("white", "grey", "red"), ((0.0, 0.0, 0.0),) * 3)
    doc.material("panel", COLORS["white"], 1.0, emissive=(1.0, 1.0, 1.0), strength=8.0)
    room = Mesh([((a, c, b), uv) for (a, b, c), uv in m.box(-2, 0, -2, 2, 2.5, 2).triangles])
    doc.mesh("room", [(room, "white", 1.0)], closed=False)
    doc.mesh("panel", [(m.box(-0.8, 2.42, -0.8, 0.8, 2.44, 0.8), "panel", 1.0)])
    doc.mesh("box", [(m.box(-0.35, 0.0, -0.35, 0.35, 0.7, 0.35), "grey", 1.0)])
    doc.mesh("plinth", [(m.box(-0.5, 0.06, -0.3, 0.5, 0.12, 0.3), "red", 1.0)])
    doc.node("room", "room")
    doc.node("panel", "panel", extras=dict(NO_TEXELS))
    doc.node("box", "box", (-0.8, 0.0, -0.5), 20)
    doc.node("plinth", "plinth", (0.8, 0.0, 0.5), -10)
    doc.camera("main", (1.7, 1.5, 1.8), (-0.3, 0.3, -0.2), 60)
    return doc


def tiles():
    """A closed room of a modular kit: a floor of 3 x 3 tiles and a north wall of three panels, each an object of its own. A lamp hangs 15 cm
    off the wall beside a joint of two panels, and a strip of light under a tread lights the floor across two joints: steep, noisy light that
    runs on across every joint."""
    doc = document("tiles", ("white", "grey"), ((0.0, 0.0, 0.0),) * 3)
    doc.material("lamp", COLORS["white"], 1.0, emissive=(1.0, 0.85, 0.6), strength=400.0)
    doc.material("strip", COLORS["white"], 1.0, emissive=(1.0, 0.9, 0.75), strength=60.0)
    w, h, t = 2.25, 2.4, 1.5  # half width, height, tile width
    panel, shell = Mesh(), Mesh()
    panel.quad((-t / 2, 0, 0), (t / 2, 0, 0), (t / 2, h, 0), (-t / 2, h, 0))
    shell.quad((-w, 0, w), (-w, 0, -w), (-w, h, -w), (-w, h, w))
    shell.quad((w, 0, -w), (w, 0, w), (w, h, w), (w, h, -w))
    shell.quad((w, 0, w), (-w, 0, w), (-w, h, w), (w, h, w))
    shell.quad((-w, h, -w), (w, h, -w), (w, h, w), (-w, h, w))
    doc.mesh("tile", [(sheet(-t / 2, -t / 2, t / 2, t / 2), "white", 1.0)], closed=False)
    doc.mesh("panel", [(panel, "white", 1.0)], closed=False)
    doc.mesh("shell", [(shell, "white", 1.0)], closed=False)
    doc.mesh("lamp", [(m.sphere(0.05, 12, 6), "lamp", 1.0)])
    doc.mesh("tread", [(m.box(-1.4, 0.15, 0.2, 1.6, 0.19, 0.5), "grey", 1.0)])
    doc.mesh("strip", [(m.box(-1.3, 0.13, 0.44, 1.5, 0.14, 0.46), "strip", 1.0)])
    for i in range(9):
        doc.node(f"tile_{i}", "tile", (t * (i % 3 - 1), 0.0, t * (i // 3 - 1)))
    for i in range(3):
        doc.node(f"panel_{i}", "panel", (t * (i - 1), 0.0, -w))
    doc.node("shell", "shell")
    doc.node("lamp", "lamp", (-0.55, 1.3, -w + 0.15), extras=dict(NO_TEXELS))
    doc.node("tread", "tread")
    doc.node("strip", "strip", extras=dict(NO_TEXELS))
    doc.camera("main", (1.6, 1.7, 2.0), (-0.4, 0.5, -1.0), 65)
    return doc


def probe_rooms():
    """Two closed rooms that share a wall 4 cm thick, one lit by a panel, the other dark but for a faint one: probes of one must not light
    what stands in the other."""
    doc = document("probe_rooms", ("white", "grey"), ((0.0, 0.0, 0.0),) * 3)
    doc.material("bright", COLORS["white"], 1.0, emissive=(1.0, 1.0, 1.0), strength=20.0)
    doc.material("faint", COLORS["white"], 1.0, emissive=(0.02, 0.02, 0.02))
    xs = [-4.04, -4.0, -0.02, 0.02, 4.0, 4.04]
    house = m.grid_solid(xs, [-0.04, 0.0, 2.5, 2.54], [-2.04, -2.0, 2.0, 2.04],
                         lambda x, y, z: not (0 < y < 2.5 and abs(z) < 2 and 0.02 < abs(x) < 4.0))
    doc.mesh("house", [(house, "white", 1.0)], closed=False)
    doc.mesh("panel_bright", [(m.box(-0.6, 2.4, -0.6, 0.6, 2.42, 0.6), "bright", 1.0)])
    doc.mesh("panel_faint", [(m.box(-0.6, 2.4, -0.6, 0.6, 2.42, 0.6), "faint", 1.0)])
    doc.mesh("block", [(m.box(-0.4, 0.0, -0.4, 0.4, 1.2, 0.4), "grey", 1.0)])
    doc.node("house", "house")
    doc.node("panel_bright", "panel_bright", (-2, 0, 0))
    doc.node("panel_faint", "panel_faint", (2, 0, 0))
    doc.node("block", "block", (-3.0, 0.0, 1.0), 20)
    doc.camera("main", (3.6, 1.6, 1.7), (0.8, 0.9, -0.6), 65)
    return doc


if __name__ == "__main__":
    gltf.write_scenes("quality", (leaks, cellars, rims, seams, curtain, mask_edges, terminator, contact, tiles, probe_rooms))
