#!/usr/bin/env python3
"""Makes the small scenes of the tests in assets/tests/: each one question with a known answer, a camera named "main".

    scripts/make_test_scenes.py [FOLDER]

X east, Y up, metres. assets/README.md lists them.
"""

import math
import random

from scenekit import gltf, mesh as m, texture
from scenekit.mesh import Mesh
from scenekit.rooms import DYNAMIC, MIXED, coloured_glass, document, light_groups, metal_rooms


def inside_walls(x0, y0, z0, x1, y1, z1):
    """A box's six sides as sheets that face inwards."""
    mesh = m.box(x0, y0, z0, x1, y1, z1)
    return Mesh([((a, c, b), uv) for (a, b, c), uv in mesh.triangles])


def closed_room():
    """Two rooms of zero-thickness walls under a bright sky: one single-sided (fronts inside), one double-sided. Nothing lights
    their insides: every texel and pixel in there is black, whatever the sky."""
    doc = document("closed_room", ("white", "grey"), ([50.0, 50.0, 50.0],) * 3)
    doc.material("double", (0.8, 0.8, 0.8), roughness=1.0, double_sided=True)
    doc.mesh("room_single_sided", [(inside_walls(-2, 0, -2, 2, 2.5, 2), "white", 1.0)], closed=False)
    doc.mesh("room_double_sided", [(inside_walls(-2, 0, -2, 2, 2.5, 2), "double", 1.0)], closed=False)
    doc.mesh("block", [(m.box(-0.4, 0.0, -0.4, 0.4, 0.8, 0.4), "grey", 1.0)])
    for name, x in (("single_sided", -3.0), ("double_sided", 3.0)):
        doc.node(f"room_{name}", f"room_{name}", (x, 0, 0))
        doc.node(f"block_{name}", "block", (x + 0.8, 0.001, -0.5))
    doc.camera("main", (-4.6, 1.6, 1.7), (-2.2, 0.8, -0.9), 60)
    doc.camera("double_sided", (1.4, 1.6, 1.7), (3.8, 0.8, -0.9), 60)
    return doc


def penumbra():
    """Sun of 4° straight above a blocker that covers x < 0 at height 2: across x, the floor's attenuation is the share of the
    sun's disc seen past a straight edge, 1/2 + (t √(1 - t²) + asin t) / π with t = x / (2 tan 2°)."""
    doc = document("penumbra", ("white", "grey"))
    doc.mesh("floor", [(m.box(-2, -0.1, -2, 2, 0, 2), "white", 1.0)])
    doc.mesh("blocker", [(m.box(-6, 2.0, -6, 0, 2.001, 6), "grey", 1.0)])
    doc.node("floor", "floor")
    # A millimetre thick: half a per mille of its height, far below what a bake resolves.
    doc.node("blocker", "blocker", extras={"halflight_lightmap_scale": 0})
    doc.light("sun", "directional", (1, 1, 1), math.pi, (0, 10, 0), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 4.0})
    doc.camera("main", (0.9, 1.6, 2.6), (0.0, 0.0, 0.0), 45)
    return doc


def five_lights():
    """Five mixed points whose ranges all overlap, of clearly different weight: four get a channel, the weakest is fully baked."""
    doc = document("five_lights", ("white", "grey", "red"), ([0.05, 0.06, 0.08], [0.05, 0.05, 0.05], [0.02, 0.02, 0.02]))
    doc.mesh("floor", [(m.box(-4, -0.2, -4, 4, 0, 4), "white", 1.0)])
    doc.mesh("box", [(m.bevel_box(0.5, 0.8, 0.5, 0.02), "grey", 1.0)])
    doc.mesh("ball", [(m.sphere(0.3, 32, 16), "red", 1.0)])
    doc.node("floor", "floor")
    for i in range(6):
        a = math.radians(60 * i)
        doc.node(f"box_{i + 1}", "box", (1.6 * math.cos(a), -0.005, 1.6 * math.sin(a)), 17 * i)
    doc.node("ball", "ball", (0, 0.3, 0), extras=dict(DYNAMIC))
    colors = ((1.0, 0.9, 0.8), (1.0, 0.3, 0.2), (0.3, 1.0, 0.3), (0.3, 0.45, 1.0), (1.0, 0.3, 0.9))
    for i, (color, candela) in enumerate(zip(colors, (10.0, 8.0, 7.0, 6.0, 1.5))):
        a = math.radians(72 * i + 18)
        doc.light(f"point_{i + 1}", "point", color, candela, (2.6 * math.cos(a), 1.9, 2.6 * math.sin(a)), cone_range=8.0,
                  extras={**MIXED, "halflight_radius": 0.03})
    doc.camera("main", (0.0, 5.2, 5.6), (0.0, 0.0, 0.2), 50)
    return doc


def thirteen_lights():
    """A room in which thirteen mixed lamps reach everything: four mask layers. A dynamic ball takes one probe sample, a dynamic
    beam is long enough for a proxy volume."""
    doc = document("thirteen_lights", ("white", "grey", "red"), ([0.02, 0.02, 0.03],) * 3)
    doc.mesh("room", [(inside_walls(-5, 0, -4, 5, 3.2, 4), "white", 1.0)], closed=False)
    doc.mesh("post", [(m.bevel_box(0.3, 1.6, 0.3, 0.02), "grey", 1.0)])
    doc.mesh("ball", [(m.sphere(0.35, 32, 16), "red", 1.0)])
    doc.mesh("beam", [(m.box(-1.4, 0, -0.15, 1.4, 0.3, 0.15), "grey", 1.0)])
    doc.node("room", "room")
    for i in range(5):
        a = math.radians(72 * i + 10)
        doc.node(f"post_{i + 1}", "post", (2.2 * math.cos(a), -0.005, 1.7 * math.sin(a)), 23 * i)
    doc.node("ball", "ball", (-0.6, 0.35, -0.6), extras=dict(DYNAMIC))
    doc.node("beam", "beam", (0.3, 0.6, 1.1), extras={**DYNAMIC, "halflight_probes": "volume", "halflight_probe_resolution": [9, 2, 2]})
    for i in range(13):
        a = math.radians(360 * i / 13 + 5)
        hue = 2 * math.pi * i / 13
        color = [0.55 + 0.45 * math.cos(hue + shift) for shift in (0.0, 2.1, 4.2)]
        doc.light(f"lamp_{i + 1}", "point", color, 1.6 + 0.1 * i, (4.1 * math.cos(a), 2.3, 3.2 * math.sin(a)), cone_range=14.0,
                  extras={**MIXED, "halflight_radius": 0.04})
    doc.camera("main", (0.0, 3.0, 3.9), (0.0, 0.25, -0.5), 36)
    return doc


def sphere_on_floor():
    """A static and a dynamic sphere side by side on a floor under a mixed sun: the same shadow, one baked, one realtime."""
    doc = document("sphere_on_floor", ("white", "red"), ([0.2, 0.3, 0.5], [0.5, 0.5, 0.5], [0.1, 0.1, 0.1]))
    doc.mesh("floor", [(m.box(-4, -0.2, -3, 4, 0, 3), "white", 1.0)])
    doc.mesh("sphere", [(m.sphere(0.5, 40, 20), "red", 1.0)])
    doc.node("floor", "floor")
    doc.node("sphere_static", "sphere", (-1.2, 0.5, 0))
    doc.node("sphere_dynamic", "sphere", (1.2, 0.5, 0), extras=dict(DYNAMIC))
    doc.light("sun", "directional", (1, 1, 1), 4.0, (-3, 6, 3), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 0.53})
    doc.camera("main", (0.0, 2.6, 5.0), (0.0, 0.3, 0.0), 45)
    return doc


def area_lights():
    """A rectangle and a disk over gloss, metal and dull surfaces: soft masks, highlights in the lights' shapes."""
    doc = document("area_lights", ("white", "red", "slate", "steel"), ([0.01] * 3,) * 3)
    doc.mesh("floor", [(m.box(-4, -0.2, -2, 4, 0, 4), "slate", 1.0)])
    doc.mesh("wall", [(m.box(-4, 0, -2.2, 4, 3.4, -2), "white", 1.0)])
    doc.mesh("pillar", [(m.bevel_box(0.3, 1.6, 0.3, 0.02), "white", 1.0)])
    for color in ("red", "steel"):
        doc.mesh(f"sphere_{color}", [(m.sphere(0.5, 48, 24), color, 1.0)])
        doc.node(f"sphere_{color}", f"sphere_{color}", (0.3 if color == "red" else -1.3, 0.5, -0.4))
    doc.node("floor", "floor")
    doc.node("wall", "wall")
    doc.node("pillar", "pillar", (1.6, 0, 0.2))
    for name, at, target, size, color, nits, shape in (
            ("window", (-3.2, 1.5, 0.3), (0, 0.9, 0), (1.6, 1.8), (0.55, 0.75, 1.0), 8.0, "rectangle"),
            ("lamp", (1.4, 2.6, -0.6), (1.0, 0, 0.1), 0.7, (1.0, 0.72, 0.42), 20.0, "disk")):
        doc.node(name, at=at, rotation=gltf.look_rotation(at, target), extras={
            "halflight_area_light": shape, "halflight_size": size, "halflight_intensity": nits, "halflight_color": color})
    doc.camera("main", (0.9, 1.55, 4.6), (-0.15, 0.75, 0), 42)
    return doc


def two_rooms():
    """Two rooms 12 m apart, each with its own mixed point of range 5: the lights reach nothing in common and share a channel."""
    doc = document("two_rooms", ("white", "grey"))
    room = m.grid_solid([-2.2, -2, 2, 2.2], [-0.2, 0, 2.6, 2.8], [-2.2, -2, 2, 2.2], lambda x, y, z: not (abs(x) < 2 and abs(z) < 2 and 0 < y < 2.6))
    doc.mesh("room", [(room, "white", 1.0)], closed=False)  # outside and cavity: the cavity's volume is negative
    doc.mesh("block", [(m.bevel_box(0.7, 1.0, 0.7, 0.02), "grey", 1.0)])
    for word, x, color in (("west", -6.0, (1.0, 0.7, 0.5)), ("east", 6.0, (0.5, 0.7, 1.0))):
        doc.node(f"room_{word}", "room", (x, 0, 0))
        doc.node(f"block_{word}", "block", (x - 0.5, -0.005, -0.4), 20)
        doc.light(f"point_{word}", "point", color, 5.0, (x + 0.8, 2.1, 0.6), cone_range=5.0, extras={**MIXED, "halflight_radius": 0.05})
    doc.camera("main", (-4.3, 1.7, 1.7), (-6.7, 0.6, -0.9), 65)
    doc.camera("east", (7.7, 1.7, 1.7), (5.3, 0.6, -0.9), 65)
    return doc


def pergola(doc):
    """A floor in the sun under beams on posts, two walls in strong colours, a coloured lamp at each end: light and shadow change
    from place to place."""
    for name, color in (("orange", (0.8, 0.3, 0.05)), ("blue", (0.08, 0.25, 0.8))):
        doc.material(name, color, roughness=0.9)
    doc.mesh("floor", [(m.box(-6, -0.2, -5, 6, 0, 5), "white", 1.0)])
    doc.mesh("wall_west", [(m.box(-6.2, -0.2, -5, -6, 2.4, 5), "orange", 1.0)])
    doc.mesh("wall_east", [(m.box(6, -0.2, -5, 6.2, 2.4, 5), "blue", 1.0)])
    doc.mesh("beam", [(m.box(-0.35, 2.6, -4.2, 0.35, 2.8, 4.2), "grey", 1.0)])
    doc.mesh("post", [(m.box(-0.12, 0, -0.12, 0.12, 2.6, 0.12), "grey", 1.0)])
    for name in ("floor", "wall_west", "wall_east"):
        doc.node(name, name)
    for i in range(5):
        x = 2.2 * (i - 2)
        doc.node(f"beam_{i + 1}", "beam", (x, 0, 0))
        for j, z in enumerate((-4.0, 4.0)):
            doc.node(f"post_{i + 1}_{j + 1}", "post", (x, 0, z))
    doc.light("sun", "directional", (1.0, 0.93, 0.8), 6.0, (3, 8, 1.5), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 0.53})
    for word, x, color in (("west", -4.8, (0.2, 1.0, 0.5)), ("east", 4.8, (1.0, 0.25, 0.6))):
        doc.light(f"lamp_{word}", "point", color, 4.0, (x, 1.1, -3.6), cone_range=6.0, extras={**MIXED, "halflight_radius": 0.04})


def proxy_volume():
    """Two long dynamic planks from sun into shade: the near one lit by one probe sample, the far one by a proxy volume."""
    doc = document("proxy_volume", ("white", "grey"), ([0.25, 0.35, 0.6], [0.4, 0.4, 0.4], [0.1, 0.1, 0.1]))
    pergola(doc)
    doc.mesh("plank", [(m.bevel_box(10.0, 0.5, 0.5, 0.02), "white", 1.0)])
    doc.node("plank_single", "plank", (0, 0.35, 1.4), extras={**DYNAMIC, "halflight_probes": "single"})
    doc.node("plank_volume", "plank", (0, 0.35, -1.4),
             extras={**DYNAMIC, "halflight_probes": "volume", "halflight_probe_resolution": [33, 3, 3]})
    doc.camera("main", (0.0, 4.4, 8.2), (0.0, 0.4, 0.2), 55)
    return doc


def avenue():
    """Posts every 3 m on both sides of a road of 60 m, static ones left and dynamic ones right, under one sun whose shadows cross
    the road: where shadows fade with distance, and which do not."""
    doc = document("avenue", ("white", "grey", "red"), ([0.25, 0.4, 0.75], [0.6, 0.65, 0.7], [0.15, 0.14, 0.12]))
    doc.mesh("road", [(m.box(-7, -0.3, -64, 7, 0, 3), "white", 1.0)])
    doc.mesh("post", [(m.bevel_box(0.35, 2.2, 0.35, 0.03) + m.sphere(0.32, 20, 10).moved(0, 2.48, 0), "grey", 1.0)])
    doc.mesh("post_dynamic", [(m.bevel_box(0.35, 2.2, 0.35, 0.03) + m.sphere(0.32, 20, 10).moved(0, 2.48, 0), "red", 1.0)])
    doc.node("road", "road")
    for i in range(21):
        z = -3.0 * i
        doc.node(f"static_{i}", "post", (-2.2, -0.005, z))
        doc.node(f"dynamic_{i}", "post_dynamic", (2.2, 0, z), extras=dict(DYNAMIC))
    doc.light("sun", "directional", (1.0, 0.95, 0.85), 4.0, (-4, 5, 1.5), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 0.53})
    doc.camera("main", (0.4, 2.6, 5.5), (0.3, 0.6, -9.0), 48)
    doc.camera("high", (0.4, 7.0, 6.5), (0.3, 0.0, -9.0), 48)
    doc.camera("close", (-0.6, 1.5, 1.6), (-0.9, 0.2, -1.2), 50)
    return doc


def four_lights():
    """Four mixed spots of one colour each, whose pools all overlap among posts: four channels, and a dynamic ball among them."""
    doc = document("four_lights", ("white", "grey"), ([0.03, 0.035, 0.05],) * 3)
    doc.mesh("floor", [(m.box(-5, -0.2, -4, 5, 0, 4), "white", 1.0)])
    doc.mesh("post", [(m.bevel_box(0.4, 1.3, 0.4, 0.02), "grey", 1.0)])
    doc.mesh("ball", [(m.sphere(0.38, 32, 16), "white", 1.0)])
    doc.node("floor", "floor")
    for i, (x, z) in enumerate(((-1.5, -0.8), (1.3, -1.1), (0.1, 1.0), (-2.6, 1.2), (2.7, 1.0))):
        doc.node(f"post_{i + 1}", "post", (x, -0.005, z), 23 * i)
    doc.node("ball", "ball", (-0.3, 0.38, -0.6), extras=dict(DYNAMIC))
    for name, color, at in (("red", (1.0, 0.12, 0.1), (-3.6, 3.4, -3.2)), ("green", (0.15, 1.0, 0.2), (3.6, 3.4, -3.2)),
                            ("blue", (0.15, 0.3, 1.0), (-3.6, 3.4, 3.2)), ("white", (1.0, 0.9, 0.7), (3.6, 3.4, 3.2))):
        doc.light(name, "spot", color, 60.0, at, (0, 0, 0), cone_range=14.0, inner=30, outer=44, extras={**MIXED, "halflight_radius": 0.06})
    doc.camera("main", (0.0, 4.6, 6.4), (0.0, 0.1, 0.3), 48)
    return doc


def hall(name):
    """A hall with a red and a blue wall behind a sunny forecourt, empty."""
    doc = document(name, ("white",), ([0.3, 0.45, 0.8], [0.6, 0.65, 0.75], [0.2, 0.18, 0.15]))
    doc.material("red_wall", (0.75, 0.06, 0.05), 0.9)
    doc.material("blue_wall", (0.06, 0.12, 0.75), 0.9)
    for part, corners, material in (("floor", (-5, -0.2, -6, 5, 0, 6), "white"), ("roof", (-4.4, 2.6, -6, 4.4, 2.8, 0.56), "white"),
                                    ("back", (-4.3, -0.1, -6.1, 4.3, 2.7, -5.9), "white"),
                                    ("left", (-4.35, -0.1, -6.0, -4.1, 2.7, 0.5), "red_wall"),
                                    ("right", (4.1, -0.1, -6.0, 4.35, 2.7, 0.5), "blue_wall")):
        doc.mesh(part, [(m.box(*corners), material, 1.0)])
        doc.node(part, part)
    doc.light("sun", "directional", (1.0, 0.93, 0.8), 5.0, (-2.0, 5, 6.0), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 0.53})
    doc.camera("main", (0.0, 2.2, 6.6), (0.0, 0.75, -1.5), 52)
    return doc


def probe_hall():
    """In the hall, a row of dynamic balls from the sun into its depth, and a dynamic beam, in a proxy volume, from one wall's
    light to the other's."""
    doc = hall("probe_hall")
    doc.mesh("ball", [(m.sphere(0.32, 32, 16), "white", 1.0)])
    doc.mesh("beam", [(m.bevel_box(7.4, 0.45, 0.45, 0.03), "white", 1.0)])
    for row, x in enumerate((-3.2, -1.6, 0.0, 1.6, 3.2)):
        for i in range(4):
            doc.node(f"ball_{row}_{i}", "ball", (x, 0.32, 2.2 - 1.7 * i), extras=dict(DYNAMIC))
    doc.node("beam", "beam", (0.0, 1.35, -2.0), 22, extras={**DYNAMIC, "halflight_probes": "volume"})
    return doc


def bumpy_wall():
    """A wall of round bumps (a normal map) between a warm emissive panel on the left and a blue baked spot on the right: all its light
    is in the lightmap, which shows the bumps only where it knows directions."""
    doc = document("bumpy_wall", ("white",), ([0.02, 0.02, 0.025],) * 3)
    size, cells = 128, 4
    step = size // cells
    height = [[max(0.0, 1.0 - ((x % step - step / 2 + 0.5) ** 2 + (y % step - step / 2 + 0.5) ** 2) / (0.4 * step) ** 2) ** 0.5 * 0.4 * step
               for x in range(size)] for y in range(size)]
    normal = doc.texture(texture.normal_map(height, 0.8, 2), "bumps_normal")
    doc.material("bumpy", (0.75, 0.75, 0.75), 0.9, normal=normal)
    doc.material("panel", (0.1, 0.1, 0.1), 0.9, emissive=(1.0, 0.55, 0.22), strength=9.0)
    doc.mesh("wall", [(m.box(-2.5, 0, -0.2, 2.5, 2.6, 0), "bumpy", 0.6)])
    doc.mesh("floor", [(m.box(-3, -0.2, -0.3, 3, -0.002, 2.5), "white", 1.0)])
    doc.mesh("panel", [(m.box(-0.03, -1.0, -0.5, 0.0, 1.0, 0.5), "panel", 1.0)])
    doc.node("wall", "wall")
    doc.node("floor", "floor")
    doc.node("panel", "panel", (-2.6, 1.3, 0.55))
    doc.light("spot", "spot", (0.35, 0.55, 1.0), 30.0, (2.7, 2.3, 1.1), (0.4, 1.2, 0), cone_range=9.0, inner=35, outer=55,
              extras={"halflight_mode": "baked", "halflight_radius": 0.05})
    doc.camera("main", (0.0, 1.4, 3.3), (0.0, 1.25, 0), 46)
    return doc


def sheets():
    """Double-sided sheets that are lit differently on both sides: two boards, of which one has its back to the sun, and a shade around
    a lamp. A ball moves between them."""
    doc = document("sheets", ("white", "red"), ([0.3, 0.4, 0.6], [0.5, 0.5, 0.5], [0.1, 0.1, 0.1]))
    doc.material("sheet", (0.75, 0.6, 0.4), roughness=1.0, double_sided=True)
    doc.mesh("floor", [(m.box(-4, -0.2, -3, 4, 0, 3), "white", 1.0)])
    board = Mesh()
    board.quad((-0.8, 0, 0), (0.8, 0, 0), (0.8, 1.4, 0), (-0.8, 1.4, 0))
    doc.mesh("board", [(board, "sheet", 1.0)], closed=False)
    shade = Mesh()
    rim = [(0.35 * math.cos(i * math.pi / 10), 0.35 * math.sin(i * math.pi / 10)) for i in range(21)]
    for (x, z), (p, q) in zip(rim, rim[1:]):
        shade.quad((x, 0, z), (x, 0.5, z), (p, 0.5, q), (p, 0, q))
    doc.mesh("shade", [(shade, "sheet", 1.0)], closed=False)
    doc.mesh("ball", [(m.sphere(0.25, 24, 12), "red", 1.0)])
    doc.node("floor", "floor")
    doc.node("board_front", "board", (-1.9, 0.2, -0.4))
    doc.node("board_back", "board", (0.1, 0.2, -0.4), 180)
    doc.node("shade", "shade", (1.9, 0.7, 0.2))
    doc.node("ball", "ball", (0.2, 0.25, 0.9), extras=dict(DYNAMIC))
    doc.light("sun", "directional", (1, 1, 1), 4.0, (-2, 5, 4), (0, 0, 0), extras={**MIXED, "halflight_angular_diameter": 0.53})
    doc.light("lamp", "point", (1.0, 0.8, 0.5), 1.5, (1.9, 0.95, 0.2), cone_range=4.0, extras={**MIXED, "halflight_radius": 0.05})
    doc.camera("main", (0.3, 2.6, 4.2), (0.1, 0.6, 0), 48)
    doc.camera("behind", (0.3, 2.2, -4.4), (0.1, 0.6, 0), 48)
    return doc


INSTANCES = 1023


def instances_1023():
    """1023 dynamic balls as the instances of one node (EXT_mesh_gpu_instancing), one draw, in the hall's light and shadow: each
    takes the probes of its own place."""
    doc = hall("instances_1023")
    doc.mesh("small_ball", [(m.sphere(0.13, 20, 10), "white", 1.0)])
    generator = random.Random(1023)
    places = []
    while len(places) < INSTANCES:
        p = (generator.uniform(-3.9, 3.9), generator.uniform(0.15, 2.4), generator.uniform(-5.6, 2.6))
        if all(sum((a - b) ** 2 for a, b in zip(p, q)) > 0.28 ** 2 for q in places):
            places.append(p)
    doc.instances("balls", "small_ball", places, extras=dict(DYNAMIC))
    return doc


if __name__ == "__main__":
    gltf.write_scenes("tests", (closed_room, penumbra, five_lights, thirteen_lights, coloured_glass, light_groups, metal_rooms, sphere_on_floor, area_lights, two_rooms, proxy_volume,
                                avenue, four_lights, probe_hall, instances_1023, bumpy_wall, sheets))
