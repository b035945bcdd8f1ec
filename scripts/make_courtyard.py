#!/usr/bin/env python3
"""Makes the project's showcase scene, assets/courtyard.glb: a colonnaded courtyard with a room behind it.

    scripts/make_courtyard.py [OUT.glb]

Everything is modelled and painted here and in scenekit/: nothing is read or downloaded. X east, Y up, Z south, metres;
the court's middle is the origin. assets/README.md describes the scene.
"""

import math

from scenekit import gltf, mesh as m, parts, vertices
from scenekit.materials import materials
from scenekit.mesh import Mesh
from scenekit.parts import BAY, FLOOR

COURT_X, NORTH, SOUTH = 7.5, -5.2, 4.9  # edges of the opening in the slab
COLUMN_X, COLUMN_Z = 7.8, 5.2
TERRACE, PARAPET, ROOF = 4.5, 5.4, 7.0
DOOR, WINDOW = (-5.9, -4.7, 2.5), (-3.2, -1.2, 0.8, 2.8)  # x0, x1, head; x0, x1, sill, head
ROOM = (-7.3, 0.1, -9.8, -5.6, 3.5)  # x0, x1, z0, z1, ceiling

SUN_TO = (-0.55, 0.72, 0.42)  # towards the sun
DYNAMIC = {"halflight_static": 0}

# Texels per metre by mesh, 1 unless named. Leaves cast into the bake and take their light from the probes; what is far
# from every eye or finer than any texel gets by with few.
LIGHTMAP_SCALE = {"tree_crown": 0, "shrub": 0, "flowers": 0, "vine": 0, "vine_short": 0, "court_floor": 1.5, "walkway_floor": 1.2,
                  "foundation": 0.1, "terrace": 0.5, "roof": 0.3, "roof_tiles": 0.2, "ridge": 0.3, "rafter": 0.4, "shutter": 0.5,
                  "balustrade": 0.6, "balustrade_short": 0.6, "stair_baluster": 0.6, "crate": 0.7, "barrel": 0.7, "lantern": 0.4,
                  "spot_bracket": 0.4, "spot_hood": 0.4, "wisp_arm": 0.4, "pot_small": 0.7, "stool": 0.6}


def shell(doc):
    """Floors, walls, slab, terraces and the room: one closed solid on a grid, its faces sorted into nodes by what they are."""
    groups = {}

    def filled(x, y, z):
        if y < 0:
            return True
        if z < NORTH:
            x0, x1, z0, z1, ceiling = ROOM
            if x0 < x < x1 and z0 < z < z1 and FLOOR < y < ceiling:
                return False
            if z > z1 and (DOOR[0] < x < DOOR[1] and FLOOR < y < DOOR[2] or WINDOW[0] < x < WINDOW[1] and WINDOW[2] < y < WINDOW[3]):
                return False
            return y < ROOF
        if abs(x) > 10.6 or z > 8.0:
            return y < PARAPET
        walkway = abs(x) > COURT_X or z > SOUTH
        return y < FLOOR and (abs(x) > 7.45 or z > 4.85) or 4.3 < y < TERRACE and walkway

    def sink(centre, normal):
        x, y, z = centre
        room = ROOM[0] - 0.01 < x < ROOM[1] + 0.01 and ROOM[2] - 0.01 < z < NORTH - 0.01 and FLOOR - 0.01 < y < ROOM[4] + 0.01
        if y < -0.01:
            key = ("foundation", "stone", 0.5)
        elif normal[1] > 0 and y < 0.01:
            key = ("court_floor", "stone", 0.7) if abs(x) > 6.7 or z > 4.1 or z < -4.6 else ("court_floor", "paving", 0.5)
        elif room:
            key = ("room", "checker" if normal[1] > 0 and y < 1 else "whitewash", 1.25 if normal[1] > 0 and y < 1 else 0.5)
        elif y < FLOOR + 0.01:
            key = ("walkway_floor", "checker" if normal[1] > 0 else "stone", 1.0)
        elif z < NORTH + 0.01:
            key = ("north_building", "plaster", 0.5)
        elif normal[1] > 0:
            key = ("terrace", "terracotta" if y < TERRACE + 0.1 else "stone", 1.0)
        else:
            key = ("walls", "plaster", 0.5)
        return groups.setdefault(key, Mesh())

    m.grid_solid([-11, -10.6, -7.5, -7.45, ROOM[0], -6.7, DOOR[0], DOOR[1], WINDOW[0], WINDOW[1], ROOM[1], 6.7, 7.45, 7.5, 10.6, 11],
                 [-0.3, 0, FLOOR, WINDOW[2], DOOR[2], WINDOW[3], ROOM[4], 4.3, TERRACE, PARAPET, ROOF],
                 [-10.2, ROOM[2], ROOM[3], NORTH, -4.6, 4.1, 4.85, SOUTH, 8.0, 8.4], filled, sink)
    vertices.check_closed([t for mesh in groups.values() for t in mesh.triangles], "shell")
    for name in sorted({key[0] for key in groups}):
        doc.mesh(name, [(mesh, key[1], key[2]) for key, mesh in sorted(groups.items(), key=lambda g: g[0]) if key[0] == name], closed=False)
        doc.node(name, name)


def colonnade(doc):
    doc.mesh("column", parts.column(), crease=30)
    doc.mesh("pier", parts.pier())
    doc.mesh("arcade_long", parts.arcade(6, -0.2))
    doc.mesh("arcade_short", parts.arcade(4, 0.225))
    doc.mesh("archivolt", parts.archivolt())
    doc.mesh("pedestal", parts.pedestal())
    doc.mesh("balustrade", parts.balustrade(BAY - 0.3, 11))
    doc.mesh("balustrade_short", parts.balustrade(0.88, 4))
    for i in range(-2, 3):
        doc.node(f"column_south_{i + 3}", "column", (i * BAY, FLOOR, COLUMN_Z))
    for side, word, turn in ((-1, "west", 90), (1, "east", -90)):
        x = side * COLUMN_X
        for i in range(-1, 2):
            doc.node(f"column_{word}_{i + 2}", "column", (x, FLOOR, i * BAY))
        doc.node(f"pier_{word}_south", "pier", (x, FLOOR, COLUMN_Z))
        doc.node(f"pier_{word}_north", "pier", (x, FLOOR, -COLUMN_Z + 0.12))
        doc.node(f"arcade_{word}", "arcade_short", (x, 0, 0), turn)
        for i in range(4):
            doc.node(f"archivolt_{word}_{i + 1}", "archivolt", (x, 0, (i - 1.5) * BAY), turn)
            if side < 0 or i > 0:
                doc.node(f"balustrade_{word}_{i + 1}", "balustrade", (x, TERRACE - 0.01, (i - 1.5) * BAY), turn)
        for i in range(5):
            if side < 0 or i > 0:
                doc.node(f"pedestal_{word}_{i + 1}", "pedestal", (x, TERRACE, (i - 2) * BAY + (0.19 if i == 0 else 0)))
    doc.node("pedestal_stair", "pedestal", (COLUMN_X, TERRACE, -3.57))
    doc.node("balustrade_stair", "balustrade_short", (COLUMN_X, TERRACE - 0.01, -3.085), 90)
    doc.node("arcade_south", "arcade_long", (0, 0, COLUMN_Z), 180)
    for i in range(6):
        doc.node(f"archivolt_south_{i + 1}", "archivolt", ((i - 2.5) * BAY, 0, COLUMN_Z), 180)
        doc.node(f"balustrade_south_{i + 1}", "balustrade", ((i - 2.5) * BAY, TERRACE - 0.01, COLUMN_Z))
        if 0 < i:
            doc.node(f"pedestal_south_{i}", "pedestal", ((i - 3) * BAY, TERRACE, COLUMN_Z))

    # Cornice around the court, and beams under the walkways' ceiling.
    profile = [(-0.05, 4.2), (0.03, 4.2), (0.03, 4.26), (0.07, 4.28), (0.07, 4.3), (0.1, 4.31), (0.14, 4.34), (0.16, 4.38), (0.2, 4.39),
               (0.2, 4.47), (-0.05, 4.47)]
    x = COURT_X - 0.005
    corners = [(-x, NORTH), (x, NORTH), (x, SOUTH), (-x, SOUTH)]
    # The strip's back stands in the slab's edge; below the slab it covers the arcade's face.
    doc.mesh("cornice", [(m.sweep([(px - 0.03 if px < 0 else px, py) for px, py in profile], m.miter_frames(corners, True), True), "stone", 1.0)])
    doc.node("cornice", "cornice")
    doc.mesh("beam", [(m.bevel_box(0.16, 0.24, 2.9, 0.015), "wood", 1.25)])
    for side, word in ((-1, "west"), (1, "east")):
        for i in range(14):
            doc.node(f"beam_{word}_{i + 1}", "beam", (side * 9.3, 4.09, -4.55 + 0.88 * i), 90)
    for i in range(16):
        doc.node(f"beam_south_{i + 1}", "beam", ((i - 7.5) * 0.94, 4.09, 6.7))


def north_side(doc):
    """Door, window, shutters, roof and the stair on the north building's face."""
    doc.mesh("door", parts.door())
    doc.node("door", "door", ((DOOR[0] + DOOR[1]) / 2, FLOOR, NORTH - 0.2))
    doc.mesh("door_frame", parts.frame(DOOR[1] - DOOR[0], DOOR[2] - FLOOR))
    doc.node("door_frame", "door_frame", ((DOOR[0] + DOOR[1]) / 2, FLOOR, NORTH))
    doc.mesh("threshold", [(m.bevel_box(1.9, 0.17, 0.62, 0.015), "stone", 1.0)])
    doc.node("threshold", "threshold", ((DOOR[0] + DOOR[1]) / 2, -0.01, NORTH + 0.27))
    width, height, middle = WINDOW[1] - WINDOW[0], WINDOW[3] - WINDOW[2], (WINDOW[0] + WINDOW[1]) / 2
    doc.mesh("window_frame", parts.frame(width, height, 0.16, 0.06, sill=True))
    doc.node("window_frame", "window_frame", (middle, WINDOW[2], NORTH))
    doc.mesh("window_bars", parts.window_bars(width, height))
    doc.node("window_bars", "window_bars", (middle, WINDOW[2], NORTH - 0.15))
    doc.mesh("shutter_large", parts.shutter(0.62, height))
    for side, word in ((-1, "left"), (1, "right")):
        doc.node(f"shutter_window_{word}", "shutter_large", (middle + side * (width / 2 + 0.16 + 0.36), WINDOW[2], NORTH + 0.012))
    doc.mesh("shutter", parts.shutter(0.5, 1.3))
    doc.mesh("upper_frame", parts.frame(1.02, 1.3, 0.14, 0.08, sill=True))
    for i, x in enumerate((-6.2, -2.2, 1.8, 5.6)):
        doc.node(f"upper_frame_{i + 1}", "upper_frame", (x, 5.1, NORTH))
        for side, word in ((-1, "left"), (1, "right")):
            doc.node(f"upper_shutter_{i + 1}_{word}", "shutter", (x + side * 0.255, 5.1, NORTH - 0.01))

    # Roof: a solid gable under barrel tiles, its eaves on rafters.
    low, ridge, front, back = 6.9, 8.55, -4.72, -10.68
    gable = [(front, low), (front, low + 0.1), ((front + back) / 2, ridge), (back, low + 0.1), (back, low)]
    doc.mesh("roof", [(m.sweep([(z, y) for z, y in gable], [((x, 0, 0), (0, 0, 1), (0, 1, 0)) for x in (-11.3, 11.3)]), "wood", 1.25)])
    doc.node("roof", "roof")
    run, rise = (front - back) / 2, ridge - low - 0.1
    slope = math.hypot(run, rise)
    doc.mesh("roof_tiles", [(mesh.turned("x", math.degrees(math.atan2(rise, run))), name, d) for mesh, name, d in parts.roof_tiles(6, 9, slope / 9.05)])
    for i in range(14):
        x = (i - 6.5) * 1.6
        doc.node(f"tiles_front_{i + 1}", "roof_tiles", (x, low + 0.085, front + 0.06))
        doc.node(f"tiles_back_{i + 1}", "roof_tiles", (x, low + 0.085, back - 0.06), 180)
    doc.mesh("ridge", [(m.sweep(parts.arc(0, 0, 0.15, -15, 195, 10), [((x, ridge + 0.02, (front + back) / 2), (0, 0, 1), (0, 1, 0)) for x in (-11.36, 11.36)]), "terracotta", 1.0)])
    doc.node("ridge", "ridge")
    doc.mesh("rafter", [(m.bevel_box(0.1, 0.14, 0.6, 0.01), "wood", 1.25)])
    for i in range(24):
        doc.node(f"rafter_{i + 1}", "rafter", ((i - 11.5) * 0.94, low - 0.13, NORTH + 0.2))

    # Stair along the face up to the east terrace, with treads and a balustrade.
    risers, run, width = 25, 0.26, 1.5
    rise = TERRACE / risers
    flight, length = parts.stair(risers, rise, run, 0.9, width)
    start = COURT_X + 0.02 - length
    doc.mesh("stair", flight)
    doc.node("stair", "stair", (start, 0, NORTH - 0.02))
    doc.mesh("tread", [(m.bevel_box(run + 0.03, 0.05, width + 0.03, 0.012), "stone", 1.0)])
    doc.mesh("stair_baluster", [(m.lathe(parts.BALUSTER, 14).scaled(0.85, 1.35, 0.85), "stone", 1.0)])
    for i in range(risers - 1):
        x, y = start + run * (i + 0.5), rise * (i + 1)
        doc.node(f"tread_{i + 1}", "tread", (x - 0.015, y - 0.028, NORTH + width / 2 - 0.015))
        doc.node(f"stair_baluster_{i + 1}", "stair_baluster", (x, y + 0.01, NORTH + width - 0.13))
    z, y0, y1 = NORTH + width - 0.13, rise + 0.83, TERRACE + 0.83
    x0, x1 = start + run * 0.5, start + run * 0.5 + run * (risers - 1)
    rail = [(-0.09, -0.05), (0.09, -0.05), (0.1, 0.0), (0.06, 0.06), (-0.06, 0.06), (-0.1, 0.0)]
    frames = [((x, y, z), (0, 0, 1), (0, 1, 0)) for x, y in ((x0 - 0.12, y0 - 0.083), (x1, y1), (COURT_X + 0.1, y1))]
    doc.mesh("stair_rail", [(m.sweep(rail, frames), "stone", 1.0)])
    doc.node("stair_rail", "stair_rail")
    doc.mesh("newel", [(m.bevel_box(0.28, 1.2, 0.28, 0.02) + m.bevel_box(0.36, 0.08, 0.36, 0.02).moved(0, 1.17, 0) +
                        m.sphere(0.14, 32, 20).moved(0, 1.36, 0), "stone", 1.0)])
    doc.node("newel", "newel", (start - 0.1, -0.01, z))
    for i, x in enumerate((start + length - 0.75, start + length - 0.45)):
        doc.node(f"landing_baluster_{i + 1}", "stair_baluster", (x, TERRACE - 0.004, z))


def garden(doc):
    doc.mesh("fountain", parts.fountain(), crease=40)
    doc.node("fountain", "fountain")
    doc.mesh("water", parts.water())
    doc.node("water", "water")
    trunk, crown = parts.tree(5)
    doc.mesh("tree_trunk", trunk)
    doc.mesh("tree_crown", crown, closed=False)
    doc.mesh("planter", [(m.bevel_box(1.3, 0.5, 1.3, 0.03).moved(0, -0.01, 0) + m.bevel_box(1.4, 0.08, 1.4, 0.02).moved(0, 0.44, 0), "stone", 1.0),
                         (m.bevel_box(1.1, 0.05, 1.1, 0.02).moved(0, 0.5, 0), "soil", 1.0)])
    for i, (x, z, turn, scale) in enumerate(((4.6, 1.2, 20, 1.12), (6.2, 3.75, 200, 0.9))):
        if i == 0:
            doc.node("planter_1", "planter", (x, 0, z))
        doc.node(f"tree_trunk_{i + 1}", "tree_trunk", (x, 0.52 if i == 0 else 0.44, z), turn, scale=scale)
        doc.node(f"tree_crown_{i + 1}", "tree_crown", (x, 0.52 if i == 0 else 0.44, z), turn, scale=scale)
    doc.mesh("pot_large", parts.pot(0.42, 0.62))
    doc.mesh("pot_small", parts.pot(0.24, 0.36))
    doc.mesh("shrub", [(parts.ball_of_leaves(0.42, 150, 91, 0.24), "leaf", 1.0)], closed=False)
    doc.mesh("flowers", [(parts.ball_of_leaves(0.25, 60, 92, 0.19), "leaf", 1.0), (parts.ball_of_leaves(0.29, 55, 93, 0.15), "bloom", 1.0)], closed=False)
    doc.node("pot_tree", "pot_large", (6.2, 0, 3.75))
    for i, (x, y, z) in enumerate(((-0.25, 0, -4.75), (-3.85, 0, -4.72), (-6.75, 0, 4.2), (9.9, FLOOR, -4.3))):
        doc.node(f"pot_large_{i + 1}", "pot_large", (x, y, z), 40 * i)
        doc.node(f"shrub_{i + 1}", "shrub", (x, y + 0.95, z), 70 * i)
    for i, (x, y, z) in enumerate(((-0.2, 0, -4.05), (-1.0, 0, -4.8), (-6.6, 0, -4.75), (6.6, 0, -3.3), (2.2, 0, 4.45), (-2.2, 0, 4.45),
                                   (7.8, TERRACE + 0.88, 0), (7.8, TERRACE + 0.88, 2.6), (-7.8, TERRACE + 0.88, 0))):
        doc.node(f"pot_small_{i + 1}", "pot_small", (x, y, z), 50 * i)
        doc.node(f"flowers_{i + 1}", "flowers", (x, y + 0.52, z), 80 * i)
    doc.mesh("vine", parts.vine(4.4, 95), closed=False)
    doc.mesh("vine_short", parts.vine(2.6, 96), closed=False)
    doc.node("vine_east", "vine", (7.56, 4.75, 3.0), -90)
    doc.node("vine_north", "vine_short", (-6.3, 4.8, NORTH))
    doc.node("vine_west", "vine", (-7.56, 4.75, 2.2), 90)
    doc.mesh("bench", parts.bench())
    for i, (x, y, z, turn) in enumerate(((0.0, FLOOR, 7.55, 180), (10.2, FLOOR, 2.6, -90), (-10.2, FLOOR, -1.3, 90), (3.1, 0, 3.9, 180))):
        doc.node(f"bench_{i + 1}", "bench", (x, y, z), turn)
    doc.mesh("crate", parts.crate(0.6))
    doc.mesh("barrel", parts.barrel())
    for i, (x, y, z, turn, scale) in enumerate(((9.9, FLOOR, 7.3, 12, 1.0), (9.15, FLOOR, 7.4, -20, 1.0), (9.6, FLOOR + 0.6, 7.35, 30, 0.8))):
        doc.node(f"crate_{i + 1}", "crate", (x, y, z), turn, scale=scale)
    for i, (x, z) in enumerate(((10.15, 6.3), (-10.1, 6.7), (-10.1, 7.4))):
        doc.node(f"barrel_{i + 1}", "barrel", (x, FLOOR, z), 25 * i)


def furniture(doc):
    """The room: a lit panel on the end wall, table, shelf, stools, rug, pictures."""
    doc.mesh("panel_frame", [(m.bevel_box(2.0, 1.2, 0.08, 0.02), "wood", 1.25)])
    doc.node("panel_frame", "panel_frame", (ROOM[1] - 0.03, 1.25, -8.5), -90)
    doc.mesh("panel", [(m.bevel_box(1.8, 1.0, 0.04, 0.01), "panel", 1.0)])
    doc.node("panel", "panel", (ROOM[1] - 0.07, 1.35, -8.5), -90)
    doc.mesh("table", parts.table(1.9, 0.85, 0.78))
    doc.node("table", "table", (-4.8, FLOOR, -6.75), 8)
    doc.mesh("stool", [(m.cylinder(0.19, 0.05, 28, 0.012).moved(0, 0.42, 0), "wood", 1.25)] +
             [(m.bar((0.09 * c, 0.44, 0.09 * s), (0.16 * c, 0.0, 0.16 * s), 0.02, 10), "wood", 1.25) for c, s in ((1, 1), (1, -1), (-1, 1), (-1, -1))])
    for i, (x, z) in enumerate(((-5.2, -7.5), (-4.2, -7.6), (-3.45, -6.9))):
        doc.node(f"stool_{i + 1}", "stool", (x, FLOOR, z), 30 * i)
    doc.mesh("rug", [(m.bevel_box(3.2, 0.022, 2.3, 0.008), "rug", 1.0)])
    doc.node("rug", "rug", (-4.4, FLOOR - 0.004, -7.1), 4)
    doc.mesh("shelf", [(m.bevel_box(0.36, 0.05, 2.2, 0.01) + m.bevel_box(0.36, 0.05, 2.2, 0.01).moved(0, 0.55, 0) + m.bevel_box(0.36, 0.05, 2.2, 0.01).moved(0, 1.1, 0) +
                        m.bevel_box(0.37, 1.7, 0.05, 0.01).moved(0, -0.3, -1.09) + m.bevel_box(0.37, 1.7, 0.05, 0.01).moved(0, -0.3, 1.09), "wood", 1.25)])
    doc.node("shelf", "shelf", (ROOM[0] + 0.178, 0.7, -8.1))
    for i, (y, z, s) in enumerate(((0.75, -8.7, 0.7), (0.75, -7.6, 0.85), (1.3, -8.3, 0.75), (1.3, -7.5, 0.6), (1.85, -8.6, 0.9), (1.85, -7.8, 0.65))):
        doc.node(f"jar_{i + 1}", "pot_small", (ROOM[0] + 0.2, y, z), 60 * i, scale=s)
    doc.mesh("chest", [(m.bevel_box(1.2, 0.5, 0.55, 0.02) + m.bevel_box(1.24, 0.1, 0.59, 0.03).moved(0, 0.49, 0), "crate", 1.25)])
    doc.node("chest", "chest", (-2.5, FLOOR, -9.48), 0)


def lights(doc):
    mixed = {"halflight_mode": "mixed"}
    doc.light("sun", "directional", (1.0, 0.84, 0.62), 5.0, m.mul(SUN_TO, 20), (0, 0, 0), extras={**mixed, "halflight_angular_diameter": 0.8})

    # Two mixed spots over the door, their pools crossing on the wall and the ground.
    doc.mesh("spot_bracket", parts.spot_bracket())
    doc.mesh("spot_hood", parts.spot_hood())
    for word, x, target in (("left", -6.75, (-5.55, 0.9, -4.95)), ("right", -3.85, (-5.05, 0.9, -4.95))):
        at = (x, 3.55, NORTH + 0.7)
        doc.node(f"bracket_{word}", "spot_bracket", (x, 3.62, NORTH))
        doc.node(f"hood_{word}", "spot_hood", at, rotation=gltf.look_rotation(at, target))
        doc.light(f"spot_door_{word}", "spot", (1.0, 0.68, 0.4), 42.0, at, target, 6.0, 18, 42, {**mixed, "halflight_radius": 0.04})

    # Two mixed points, out of each other's range.
    doc.mesh("lantern", parts.lantern())
    flame = m.lathe([(0, -0.09), (0.008, -0.082), (0.013, -0.068), (0.009, -0.045), (0, -0.02)], 10)
    doc.mesh("flame", [(flame, "flame", 1.0)])
    for name, at, candela, reach in (("lantern_room", (-3.6, 2.55, -7.8), 9.0, 5.5), ("lantern_walkway", (9.1, 3.14, 1.75), 15.0, 5.5)):
        doc.node(name, "lantern", at)
        doc.node(f"flame_{name}", "flame", at, extras={**DYNAMIC, "halflight_cast_shadows": 0})
        doc.light(f"point_{name}", "point", (1.0, 0.72, 0.45), candela, at, cone_range=reach, extras={**mixed, "halflight_radius": 0.05})

    # One realtime spot in a cold colour, hung under an arch of the shaded west side.
    at, target = (-7.45, 3.1, 1.3), (-4.75, 0.1, 0.0)
    doc.node("hood_wisp", "spot_hood", at, rotation=gltf.look_rotation(at, target))
    doc.mesh("wisp_arm", [(m.bar((-7.62, 3.64, 1.3), (-7.5, 3.28, 1.3), 0.015, 8) + m.bar((-7.75, 3.66, 1.3), (-7.58, 3.62, 1.3), 0.02, 8), "iron", 1.0)])
    doc.node("wisp_arm", "wisp_arm")
    doc.light("spot_realtime", "spot", (0.2, 0.72, 1.0), 75.0, at, target, 7.0, 14, 27, {"halflight_mode": "realtime", "halflight_radius": 0.03})


def dynamic_objects(doc):
    def solid(name, mesh, material, crease=50):
        doc.mesh(name, [(mesh, material, 1.0)], crease=crease)

    solid("sphere_red", m.sphere(0.45, 56, 28), "red")
    solid("sphere_ivory", m.sphere(0.3, 48, 24), "ivory")
    solid("sphere_blue", m.sphere(0.22, 40, 20), "blue")
    solid("knot", parts.torus_knot(2, 3, 0.36, 0.17, 0.085), "brass")
    solid("knot_jade", parts.torus_knot(3, 2, 0.28, 0.12, 0.06), "jade")
    solid("figure_maple", parts.figure(), "maple")
    solid("figure_blue", parts.figure(), "blue")
    solid("ring", parts.torus(0.38, 0.1), "ochre")
    solid("teapot", parts.teapot(), "brass")
    solid("cube", m.bevel_box(0.6, 0.6, 0.6, 0.03), "ochre")
    solid("cone", m.lathe([(0, 0), (0.33, 0), (0.345, 0.015), (0.02, 0.86), (0, 0.875)], 48), "jade", 40)

    def put(name, mesh, at, turn=0, scale=None, rotation=None):
        doc.node(name, mesh, at, turn, rotation, scale, dict(DYNAMIC))

    # Where the west arcade's shadow ends on the court, in the sun, in the arches' light, in the shade, in the room.
    put("dynamic_sphere_edge", "sphere_red", (-3.7, 0.45, 1.35))
    put("dynamic_figure_court", "figure_maple", (-2.3, 0, -2.2), 35)
    put("dynamic_figure_arch", "figure_blue", (8.7, FLOOR, -1.1), -70)
    put("dynamic_crate_sun", "crate", (-0.3, 0, -2.75), 25)
    put("dynamic_crate_top", "crate", (-0.3, 0.6, -2.75), 55, 0.7)
    put("dynamic_sphere_sun", "sphere_ivory", (1.75, 0.3, -2.45))
    put("dynamic_knot_realtime", "knot", (-4.75, 0, 0.0), 15)
    put("dynamic_cube_edge", "cube", (-3.9, 0, -3.0), 30)
    put("dynamic_cone", "cone", (-0.55, 0, 2.1))
    put("dynamic_ring_pier", "ring", (7.1, 0.48, 1.6), -75)
    put("dynamic_figure_door", "figure_maple", (-4.55, 0, -3.85), 200)
    put("dynamic_sphere_door", "sphere_blue", (-5.5, 0.22, -3.7))
    put("dynamic_knot_walkway", "knot_jade", (8.9, FLOOR, 0.8), 40)
    put("dynamic_teapot", "teapot", (-4.9, FLOOR + 0.78, -6.75), -30)
    put("dynamic_sphere_room", "sphere_ivory", (-1.0, FLOOR + 0.3, -6.6))


def cameras(doc):
    doc.camera("showcase", (-6.9, 1.85, 4.0), (0.2, 1.55, -2.6), 52)
    doc.camera("room", (-6.5, 1.75, -9.35), (-1.4, 1.0, -7.6), 60)
    doc.camera("top", (-6.8, 13.0, 10.4), (0.2, 0.0, -0.9), 38)
    doc.camera("detail", (9.95, 1.7, 5.3), (8.75, 1.5, -1.5), 56)


def make():
    doc = gltf.Document("Halflight scripts/make_courtyard.py")
    doc.scene("courtyard", {"halflight_sky_zenith": [0.13, 0.29, 0.72], "halflight_sky_horizon": [0.52, 0.65, 0.84],
                            "halflight_sky_ground": [0.2, 0.16, 0.12], "halflight_shadow_color": [0.5, 0.5, 0.55]})
    materials(doc)
    for build in (shell, colonnade, north_side, garden, furniture, lights, dynamic_objects, cameras):
        build(doc)
    doc.scale_lightmaps(LIGHTMAP_SCALE)
    return doc


if __name__ == "__main__":
    gltf.write_showcase("courtyard", make)
