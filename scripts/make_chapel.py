#!/usr/bin/env python3
"""Makes the project's second showcase, assets/chapel.glb: a chapel with stained glass, whose light changes.

    scripts/make_chapel.py [OUT.glb]

Everything is modelled and painted here and in scenekit/: nothing is read or downloaded. X south, Y up, Z west, metres; the
middle of the nave's floor is the origin, and the altar is at negative Z. assets/README.md describes the scene and its light groups.
"""

import math

from scenekit import chapel, glass, gltf, gothic, mesh as m, parts, texture, vertices
from scenekit.mesh import Mesh

BAYS, BAY = 5, 3.0
END = BAYS * BAY / 2  # inner faces of the end walls
WIDE, THICK = 4.6, 0.45  # inner faces of the aisles' walls, and their thickness
ARCADE, HALF_WALL = 2.6, 0.25  # middle of the arcades, and half their thickness
AISLE, TOP = 4.3, 9.0  # heights of the aisles' ceilings and of the end walls
PILLAR = 2.7  # height of the arches' springing
ARCH = (1.14, 1.5)  # half width and radius of the arcade's arches
VAULT = (2.35, 5.9, 2.7)  # half width, springing, radius
WINDOW = (1.3, 2.75, 0.48, 1.0)  # sill, springing, half width, radius
ROSE, ROSE_HEIGHT = 1.35, 5.15
OCULUS = 5.2  # height of the clerestory's windows
CHANCEL, ALTAR = -4.4, -6.35
HEARTH = -3.0  # Z of the fireplace in the north aisle
SUN_TO = (0.86, 0.37, 0.30)

DYNAMIC = {"halflight_static": 0}
NO_TEXELS = {"halflight_lightmap_scale": 0}
# Texels per metre by mesh, 1 unless named: what is far from every eye or finer than any texel gets by with few.
LIGHTMAP_SCALE = {"nave_floor": 1.2, "roof": 0.1, "ground": 0.03, "vault": 0.6, "rib": 0.5, "wall_shaft": 0.5, "aisle_ceiling": 0.5, "beam": 0.4,
                  "lancet_frame": 0.6, "oculus_frame": 0.5, "lantern": 0.4, "chain": 0.2, "sconce": 0.4, "candlestick": 0.6, "rail": 0.6, "door": 0.7}


def materials(doc):
    t = {name: doc.texture(make(), name) for name, make in (
        ("plaster", texture.plaster), ("limestone", texture.limestone), ("checker", texture.checker), ("wood", texture.wood))}
    color, normal = texture.paving()
    t["paving"], t["paving_normal"] = doc.texture(color, "paving"), doc.texture(normal, "paving_normal")
    doc.material("plaster", (0.88, 0.92, 1.0), texture=t["plaster"], roughness=0.95)
    doc.material("stone", (0.92, 0.9, 0.88), texture=t["limestone"], roughness=0.85)
    doc.material("paving", (0.8, 0.8, 0.82), texture=t["paving"], normal=t["paving_normal"], roughness=0.8)
    doc.material("checker", (0.85, 0.82, 0.8), texture=t["checker"], roughness=0.6)
    doc.material("wood", texture=t["wood"], roughness=0.75)
    doc.material("oak", (0.62, 0.55, 0.5), texture=t["wood"], roughness=0.7)
    doc.material("iron", (0.05, 0.05, 0.055), roughness=0.6, metallic=0.3)
    doc.material("soot", (0.06, 0.05, 0.045), roughness=1.0)
    doc.material("wax", (0.9, 0.85, 0.7), roughness=0.6)
    doc.material("linen", (0.86, 0.84, 0.78), roughness=1.0)
    doc.material("carpet", (0.36, 0.06, 0.07), roughness=1.0)
    doc.material("gold", (0.75, 0.52, 0.2), roughness=0.5, metallic=0.5)
    doc.material("azure", (0.08, 0.14, 0.36), roughness=0.7)
    doc.material("book", (0.28, 0.09, 0.06), roughness=0.7)
    doc.material("cloak", (0.12, 0.2, 0.16), roughness=0.9)
    doc.material("robe", (0.5, 0.38, 0.24), roughness=0.9)
    doc.material("flame", (1.0, 0.8, 0.5), roughness=1.0, emissive=(1.0, 0.6, 0.22), strength=14.0)
    doc.material("fire", (0.3, 0.1, 0.03), roughness=1.0, emissive=(1.0, 0.42, 0.1), strength=22.0)
    doc.material("ember", (0.08, 0.04, 0.03), roughness=1.0, emissive=(1.0, 0.22, 0.04), strength=6.0)
    for name, picture in (("lancet_a", lambda: glass.lancet(1)), ("lancet_b", lambda: glass.lancet(4)), ("rose", glass.rose)):
        doc.material(name, roughness=0.4, texture=doc.texture(picture(), name, repeat=False), double_sided=True)
        doc.json["materials"][-1]["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    doc.used.add("KHR_materials_transmission")


def floors(doc):
    """Paving with a strip of tiles along the nave, two steps to the chancel and one to the altar: one closed solid."""
    groups = {}

    def filled(x, y, z):
        height = 0.34 if z < -5.3 and abs(x) < 2.0 else 0.17 if z < CHANCEL and abs(x) < ARCADE else 0.0
        return y < height

    def sink(centre, normal):
        x, y, z = centre
        material = "paving" if normal[1] > 0 else "stone"
        if normal[1] > 0 and (abs(x) < 0.75 or y > 0.1):
            material = "checker"
        return groups.setdefault(("nave_floor" if y > -0.05 else "foundation", material), Mesh())

    edge = WIDE + THICK
    xs = [-edge, -ARCADE, -2.0, -0.75, 0.75, 2.0, ARCADE, edge]
    m.grid_solid(xs, [-0.3, 0, 0.17, 0.34], [-END - 0.5, -5.3, CHANCEL, END + 0.5], filled, sink)
    vertices.check_closed([t for mesh in groups.values() for t in mesh.triangles], "floors")
    for name in ("nave_floor", "foundation"):
        found = [(mesh, material, 0.9 if material == "checker" else 0.5) for (owner, material), mesh in sorted(groups.items()) if owner == name]
        doc.mesh(name, found, closed=False)
        doc.node(name, name, extras=NO_TEXELS if name == "foundation" else None)


def walls(doc):
    """Aisles, arcades with their clerestory, and both ends."""
    def bays(side):
        return [i for i in range(BAYS) if side > 0 or i != 1]  # the fireplace takes the place of a window

    for side, word, turn in ((1, "south", -90), (-1, "north", 90)):
        # Local x runs along the wall; inside is +z.
        place = lambda i: side * (i - 2) * BAY
        windows = [gothic.lancet(place(i), *WINDOW) for i in bays(side)]
        doc.mesh(f"wall_{word}", [(gothic.wall(-END - 0.48, END + 0.48, -0.1, AISLE + 0.3, windows, -THICK, 0), "plaster", 0.5)])
        doc.node(f"wall_{word}", f"wall_{word}", (side * WIDE, 0, 0), turn)
        arches = [gothic.Opening(gothic.pointed((i - 2) * BAY, PILLAR, *ARCH)) for i in range(BAYS)]
        oculi = [gothic.round_window((i - 2) * BAY, OCULUS, 0.42) for i in range(BAYS)]
        if side > 0:
            doc.mesh("arcade", [(gothic.wall(-END - 0.1, END + 0.1, PILLAR - 0.01, 6.3, arches + oculi, -HALF_WALL, HALF_WALL), "plaster", 0.5)])
        doc.node(f"arcade_{word}", "arcade", (side * ARCADE, 0, 0), turn)
    aisle_ends = [gothic.lancet(x, *WINDOW) for x in (-3.72, 3.72)]
    width = WIDE + THICK - 0.02
    east = [gothic.round_window(0.0, ROSE_HEIGHT, ROSE, 40), *aisle_ends]
    doc.mesh("wall_east", [(gothic.wall(-width, width, -0.12, TOP, east, -THICK, 0), "plaster", 0.5)])
    doc.node("wall_east", "wall_east", (0, 0, -END))
    west = [gothic.Opening(gothic.pointed(0.0, 2.0, 0.9, 1.2)), gothic.round_window(0.0, 5.3, 0.8, 32), *aisle_ends]
    doc.mesh("wall_west", [(gothic.wall(-width, width, -0.12, TOP, west, -THICK, 0), "plaster", 0.5)])
    doc.node("wall_west", "wall_west", (0, 0, END), 180)


def vaults(doc):
    """The nave's vault with its ribs and shafts, the aisles' ceilings, and the pillars."""
    doc.mesh("vault", gothic.vault(*VAULT, TOP - 0.05, -END - 0.1, END + 0.1))
    doc.node("vault", "vault")
    doc.mesh("rib", gothic.rib(*VAULT))
    doc.mesh("boss", chapel.boss())
    doc.mesh("pillar", gothic.pillar(PILLAR), crease=40)
    doc.mesh("arch_moulding", gothic.arch_moulding(ARCH[0], PILLAR, ARCH[1], HALF_WALL))
    shaft = m.lathe([(0, 0.02), (0.07, 0.1), (0.055, 0.16), (0.055, 3.0), (0.075, 3.02), (0.075, 3.05), (0.06, 3.07), (0.12, 3.28), (0, 3.28)], 16)
    doc.mesh("wall_shaft", [(shaft, "stone", 1.0)])
    for i in range(BAYS + 1):
        z = (i - 2.5) * BAY
        inset = 0.12 if i == 0 else -0.12 if i == BAYS else 0.0
        doc.node(f"rib_{i + 1}", "rib", (0, 0, z + inset))
        for side, word in ((-1, "north"), (1, "south")):
            doc.node(f"pillar_{word}_{i + 1}", "pillar", (side * ARCADE, 0, z))
            doc.node(f"shaft_{word}_{i + 1}", "wall_shaft", (side * (ARCADE - HALF_WALL - 0.02), PILLAR, z + inset))
            if i < BAYS:
                doc.node(f"moulding_{word}_{i + 1}", "arch_moulding", (side * ARCADE, 0, z + BAY / 2), 90)
        doc.node(f"boss_{i + 1}", "boss", (0, gothic.apex(VAULT[1], VAULT[0], VAULT[2]) - 0.12, z + inset))
    ridge = m.box(-0.08, 0, -END - 0.05, 0.08, 0.2, END + 0.05)
    doc.mesh("ridge", [(ridge, "stone", 1.0)])
    doc.node("ridge", "ridge", (0, gothic.apex(VAULT[1], VAULT[0], VAULT[2]) - 0.1, 0))
    doc.mesh("aisle_ceiling", [(m.box(0, 0, -END - 0.1, 2.3, 0.1, END + 0.1), "wood", 1.25)])
    doc.mesh("beam", [(m.bevel_box(2.2, 0.2, 0.16, 0.015), "oak", 1.25)])
    for side, word in ((-1, "north"), (1, "south")):
        doc.node(f"aisle_ceiling_{word}", "aisle_ceiling", (ARCADE + 0.1 if side > 0 else -ARCADE - 2.4, AISLE, 0))
        for i in range(10):
            doc.node(f"beam_{word}_{i + 1}", "beam", (side * 3.68, AISLE - 0.17, (i - 4.5) * 1.5))
    doc.mesh("roof", [(m.box(-3, TOP - 0.2, -END - 0.4, 3, TOP, END + 0.4), "wood", 0.5)])
    doc.node("roof", "roof", extras=NO_TEXELS)
    doc.mesh("ground", [(m.box(-40, -0.5, -40, 40, -0.2, 40), "soot", 1.0)])
    doc.node("ground", "ground", extras=NO_TEXELS)


def windows(doc):
    doc.mesh("lancet_frame", gothic.lancet_frame(*WINDOW))
    frame = gothic.trim(parts.arc(0, 0, 0.42, 0, 360, 28)[:-1], [(-0.06, -0.05), (0.08, -0.05), (0.08, 0.04), (0.02, 0.06), (-0.06, 0.0)])
    doc.mesh("oculus_frame", [(frame, "stone", 1.0)])
    for kind in "ab":
        doc.mesh(f"lancet_{kind}", gothic.lancet_pane(*WINDOW, f"lancet_{kind}"), closed=False)
    doc.mesh("oculus_glass", gothic.rose_pane(0.42, "rose"), closed=False)
    doc.mesh("rose_glass", gothic.rose_pane(ROSE, "rose"), closed=False)
    doc.mesh("rose_tracery", gothic.rose_tracery(ROSE))
    doc.mesh("west_glass", gothic.rose_pane(0.8, "rose"), closed=False)
    doc.mesh("west_tracery", gothic.rose_tracery(0.8, 8))

    def lancet_at(name, at, turn, kind):
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        doc.node(f"frame_{name}", "lancet_frame", at, turn)
        doc.node(f"glass_{name}", f"lancet_{kind}", (at[0] - 0.28 * s, at[1], at[2] - 0.28 * c), turn, extras=NO_TEXELS)

    for side, word, turn in ((1, "south", -90), (-1, "north", 90)):
        for i in range(BAYS):
            z = (i - 2) * BAY
            if side > 0 or z != HEARTH:
                lancet_at(f"{word}_{i + 1}", (side * WIDE, 0, z), turn, "ab"[i % 2])
            doc.node(f"oculus_{word}_{i + 1}", "oculus_frame", (side * (ARCADE - HALF_WALL), OCULUS, z), turn)
            doc.node(f"oculus_glass_{word}_{i + 1}", "oculus_glass", (side * ARCADE, OCULUS, z), turn, extras=NO_TEXELS)
    for end, word, turn in ((-1, "east", 0), (1, "west", 180)):
        for side in (-1, 1):
            lancet_at(f"{word}_{'left' if side < 0 else 'right'}", (side * 3.72, 0, end * END), turn, "a")
    doc.node("rose_glass", "rose_glass", (0, ROSE_HEIGHT, -END - 0.25), extras=NO_TEXELS)
    doc.node("rose_tracery", "rose_tracery", (0, ROSE_HEIGHT, -END - 0.12))
    doc.node("west_glass", "west_glass", (0, 5.3, END + 0.25), 180, extras=NO_TEXELS)
    doc.node("west_tracery", "west_tracery", (0, 5.3, END + 0.12), 180)
    leaf = gothic.wall(-0.95, 0.95, -0.05, 3.2, [], -0.08, 0.0)
    iron = Mesh()
    for y in (0.4, 1.1, 1.8):
        iron += m.bevel_box(1.6, 0.06, 0.03, 0.008).moved(0, y, 0.0)
    doc.mesh("door", [(leaf, "oak", 1.25), (iron, "iron", 1.0)])
    doc.node("door", "door", (0, 0, END + 0.2), 180)


def furniture(doc):
    for name in ("pew", "books", "stall", "station", "banner", "candle_rack", "statue"):
        doc.mesh(name, getattr(chapel, name)())
    for side, word in ((-1, "north"), (1, "south")):
        for i in range(8):
            doc.node(f"pew_{word}_{i + 1}", "pew", (side * 1.52, 0, -2.9 + 1.02 * i))
            doc.node(f"books_{word}_{i + 1}", "books", (side * 1.52 + 0.13 * (i % 3 - 1), 0, -2.9 + 1.02 * i))
    for side, word, turn in ((-1, "north", 90), (1, "south", -90)):
        doc.node(f"stall_{word}", "stall", (side * 2.42, 0.17, -5.95), turn)
        for i in range(BAYS - 1):
            z = (i - 1.5) * BAY
            if not (side, z) in ((1, -1.5), (1, 4.5), (-1, 1.5)):  # the sconces' places
                doc.node(f"station_{word}_{i + 1}", "station", (side * (WIDE - 0.01), 1.75, z), turn)
        doc.node(f"statue_{word}", "statue", (side * 1.95, 2.0, -END), 0)
        for i in (0, 2, 3):
            doc.node(f"banner_{word}_{i + 1}", "banner", (side * (ARCADE - HALF_WALL - 0.14), 4.62, (i - 1.5) * BAY + 0.55), turn)
    doc.node("candle_rack", "candle_rack", (-4.2, 0, -0.6), 90)
    # Altar, cloth, cross, candlesticks; a painted triptych behind them.
    block = m.bevel_box(1.9, 0.86, 0.7, 0.015) + m.bevel_box(2.2, 0.09, 0.86, 0.02).moved(0, 0.86, 0) + m.bevel_box(2.1, 0.1, 0.8, 0.02).moved(0, -0.01, 0)
    for i in range(4):
        block += gothic.trim(gothic.outline(0.2, 0.5, 0.16, 0.2), gothic.rectangle(-0.02, 0.03, 0.33, 0.375), True).moved((i - 1.5) * 0.46, 0, 0)
    cloth = m.bevel_box(1.5, 0.012, 0.9, 0.004).moved(0, 0.945, 0) + m.bevel_box(1.5, 0.3, 0.012, 0.004).moved(0, 0.65, 0.45)
    doc.mesh("altar", [(block, "stone", 1.0), (cloth, "linen", 1.0)])
    doc.node("altar", "altar", (0, 0.34, ALTAR))
    cross = m.bevel_box(0.05, 0.62, 0.035, 0.008) + m.bevel_box(0.36, 0.05, 0.035, 0.008).moved(0, 0.4, 0) + m.bevel_box(0.2, 0.06, 0.12, 0.015).moved(0, -0.01, 0)
    doc.mesh("cross", [(cross, "gold", 1.0)])
    doc.node("cross", "cross", (0, 0.34 + 0.95, ALTAR - 0.2))
    stick = m.lathe([(0, 0), (0.1, 0), (0.1, 0.02), (0.04, 0.05), (0.025, 0.1), (0.04, 0.16), (0.02, 0.2), (0.02, 0.4), (0.03, 0.42), (0.06, 0.45), (0.06, 0.47), (0, 0.47)], 20)
    candle = m.lathe([(0, 0.46), (0.025, 0.46), (0.025, 0.68), (0, 0.685)], 14)
    doc.mesh("candlestick", [(stick, "gold", 1.0), (candle, "wax", 1.0)])
    doc.mesh("candle_stand", [(stick.scaled(1.6, 2.2, 1.6), "iron", 1.0), (candle.scaled(1.2, 1, 1.2).moved(0, 0.55, 0), "wax", 1.0)])
    frame = Mesh()
    for x, half, top in ((0, 0.5, 1.5), (-0.83, 0.28, 1.05), (0.83, 0.28, 1.05)):
        frame += gothic.trim(gothic.outline(0.05, top - 0.35, half, half * 1.4), gothic.rectangle(-0.05, 0.05, 0.0, 0.12, 0.02)).moved(x, 0, 0)
    board = Mesh()
    for x, half, top in ((0, 0.5, 1.5), (-0.83, 0.28, 1.05), (0.83, 0.28, 1.05)):
        points = gothic.outline(0.05, top - 0.35, half, half * 1.4)
        board += m.sweep(points, [((x, 0, z), (1, 0, 0), (0, 1, 0)) for z in (0.0, 0.05)])
    doc.mesh("triptych", [(frame, "gold", 1.0), (board, "azure", 1.0), (m.bevel_box(2.6, 1.36, 0.3, 0.02).moved(0, -1.36, 0.1), "stone", 1.0)])
    doc.node("triptych", "triptych", (0, 1.6, -END + 0.16))
    halo = gothic.trim(parts.arc(0, 0, 0.2, 0, 360, 28)[:-1], gothic.rectangle(-0.02, 0.02, 0, 0.03)) + m.sphere(0.1, 20, 12).scaled(1, 1.25, 0.4)
    saint = m.lathe([(0, -0.75), (0.24, -0.75), (0.2, -0.4), (0.15, -0.18), (0.06, -0.1), (0, -0.1)], 20).scaled(1, 1, 0.3)
    doc.mesh("saint", [(halo, "gold", 1.0), (saint, "robe", 1.0)])
    doc.node("saint", "saint", (0, 2.62, -END + 0.24))
    # Rails at the chancel, a carpet, a lectern with its book, a font, a kneeler by the fire.
    doc.mesh("rail", parts.balustrade(1.4, 6))
    for side, word in ((-1, "north"), (1, "south")):
        doc.node(f"rail_{word}", "rail", (side * 1.5, 0.16, CHANCEL - 0.16))
    doc.mesh("carpet", [(m.bevel_box(1.1, 0.016, 7.6, 0.006), "carpet", 1.0)])
    doc.node("carpet", "carpet", (0, -0.004, 1.4))
    lectern = m.bevel_box(0.4, 0.06, 0.4, 0.015) + m.cylinder(0.05, 1.0, 16, 0.01).moved(0, 0.04, 0) + m.bevel_box(0.5, 0.03, 0.4, 0.01).turned("x", -25).moved(0, 1.02, 0)
    book = m.bevel_box(0.36, 0.05, 0.26, 0.01).turned("x", -25).moved(0, 1.06, 0)
    doc.mesh("lectern", [(lectern, "oak", 1.25), (book, "book", 1.0)])
    doc.node("lectern", "lectern", (1.75, 0.17, -4.95), 205)
    font = m.lathe([(0, 0), (0.34, 0), (0.34, 0.08), (0.2, 0.14), (0.15, 0.3), (0.15, 0.5), (0.24, 0.6), (0.4, 0.7), (0.4, 0.92), (0.33, 0.92), (0.3, 0.74), (0, 0.72)], 8)
    doc.mesh("font", [(Mesh([(t, None) for t, _ in font.triangles]), "stone", 1.0)])
    doc.node("font", "font", (-3.7, 0, 0.3), 22.5)


def hearth(doc):
    """Fireplace in the north aisle: breast with an arched mouth, mantel, hood, logs and embers."""
    mouth = gothic.Opening(gothic.pointed(0.0, 0.75, 0.55, 0.75))
    breast = gothic.wall(-0.95, 0.95, -0.05, 1.75, [mouth], -0.1, 0.5)
    back = m.bevel_box(1.5, 1.7, 0.1, 0.01).moved(0, -0.02, -0.02)
    stone = breast + m.bevel_box(2.1, 0.13, 0.72, 0.025).moved(0, 1.7, 0.2) + m.bevel_box(1.5, 0.08, 0.5, 0.02).moved(0, -0.02, 0.72)
    hood = m.sweep([(-0.85, 0), (0.85, 0), (0.42, 2.55), (-0.42, 2.55)], [((0, 1.8, z), (1, 0, 0), (0, 1, 0)) for z in (-0.1, 0.32)])
    stone += gothic.trim(gothic.pointed(0.0, 0.75, 0.55, 0.75), gothic.rectangle(0.0, 0.14, 0.45, 0.56, 0.03), closed=False)
    doc.mesh("hearth", [(stone, "stone", 1.0), (hood, "plaster", 0.5), (back, "soot", 1.0)])
    doc.node("hearth", "hearth", (-WIDE, 0, HEARTH), 90)
    logs = Mesh()
    for x, z, turn, y in ((0.0, 0.16, 88, 0.1), (0.02, 0.34, 95, 0.1), (-0.05, 0.25, 60, 0.2), (0.06, 0.26, 120, 0.28)):
        logs += m.cylinder(0.06, 0.62, 12, 0.01).moved(0, -0.31, 0).turned("z", 90).turned("y", turn - 90).moved(x, y, z)
    irons = Mesh()
    for x in (-0.3, 0.3):
        irons += m.bevel_box(0.04, 0.04, 0.5, 0.008).moved(x, 0.02, 0.3) + m.cylinder(0.02, 0.42, 10, 0.005).moved(x, 0, 0.54) + m.sphere(0.04, 14, 8).moved(x, 0.44, 0.54)
    doc.mesh("logs", [(logs, "soot", 1.0), (irons, "iron", 1.0)])
    doc.node("logs", "logs", (-WIDE, 0.03, HEARTH), 90)
    embers = m.bevel_box(0.7, 0.05, 0.3, 0.02)
    group = {"halflight_group": "fire"}
    doc.mesh("embers", [(embers, "ember", 1.0)])
    doc.node("embers", "embers", (-WIDE + 0.26, 0.02, HEARTH), 90, extras=group)
    tongue = [(0, 0), (0.05, 0.03), (0.075, 0.1), (0.06, 0.2), (0.03, 0.31), (0, 0.4)]
    flames = Mesh()
    for x, z, size, lean in ((0, 0, 1.0, 4), (-0.14, 0.04, 0.75, -7), (0.15, 0.03, 0.8, 8), (-0.05, -0.06, 0.6, -3), (0.08, -0.05, 0.65, 5)):
        flames += m.lathe([(r * size, y * size) for r, y in tongue], 12).turned("z", -lean).moved(x, 0.2, z)
    doc.mesh("flames", [(flames, "fire", 1.0)])
    doc.node("flames", "flames", (-WIDE + 0.27, 0.03, HEARTH), 90, extras={**group, **NO_TEXELS, "halflight_cast_shadows": 0})
    doc.light("fire_glow", "point", (1.0, 0.5, 0.18), 14.0, (-WIDE + 0.62, 0.55, HEARTH), cone_range=9.0,
              extras={**group, "halflight_mode": "baked", "halflight_radius": 0.12})


def lights(doc):
    doc.light("sun", "directional", (1.0, 0.74, 0.46), 70.0, m.mul(SUN_TO, 20), (0, 0, 0),
              extras={"halflight_group": "sun", "halflight_mode": "baked", "halflight_angular_diameter": 0.6})
    flame = m.lathe([(0, -0.09), (0.008, -0.082), (0.013, -0.068), (0.009, -0.045), (0, -0.02)], 10)
    doc.mesh("flame", [(flame, "flame", 1.0)])
    doc.mesh("lantern", parts.lantern())
    warm = (1.0, 0.72, 0.44)

    def burning(name, at, group, candela, reach, mode, scale=1.0):
        extras = {"halflight_group": group}
        doc.node(f"flame_{name}", "flame", at, scale=scale, extras={**extras, **DYNAMIC, "halflight_cast_shadows": 0})
        doc.light(name, "point", warm, candela, at, cone_range=reach, extras={**extras, "halflight_mode": mode, "halflight_radius": 0.04})

    # Four lanterns over the nave, whose direct light is drawn at run time and masked.
    high = gothic.apex(VAULT[1], VAULT[0], VAULT[2])
    doc.mesh("chain", [(m.bar((0, 0.94, 0), (0, high - 3.45, 0), 0.008, 6), "iron", 1.0)])
    for i, z in enumerate((-3.0, 0.0, 3.0, 6.0)):
        at = (0, 3.45, z)
        doc.node(f"lantern_{i + 1}", "lantern", at)
        doc.node(f"chain_{i + 1}", "chain", at)
        burning(f"lamp_nave_{i + 1}", at, "nave", 7.5, 9.0, "mixed")
    # Three candles at the altar, three sconces in the aisles: all of their light is baked.
    for i, (name, mesh, at, top) in enumerate((("left", "candlestick", (-0.8, 1.29, ALTAR), 0.79), ("right", "candlestick", (0.8, 1.29, ALTAR), 0.79),
                                               ("paschal", "candle_stand", (-1.7, 0.34, -5.9), 1.35))):
        doc.node(f"candle_{name}", mesh, at)
        burning(f"lamp_altar_{i + 1}", (at[0], at[1] + top, at[2]), "altar", 5.0, 8.0, "baked")
    arm = m.bevel_box(0.1, 0.26, 0.04, 0.01) + m.bar((0, 0.1, 0.0), (0, 0.06, 0.26), 0.014, 10) + m.lathe([(0, 0.05), (0.07, 0.05), (0.08, 0.08), (0, 0.08)], 16).moved(0, 0, 0.26)
    candle = m.lathe([(0, 0.07), (0.022, 0.07), (0.022, 0.22), (0, 0.225)], 12).moved(0, 0, 0.26)
    doc.mesh("sconce", [(arm, "iron", 1.0), (candle, "wax", 1.0)])
    for i, (side, z) in enumerate(((1, -1.5), (1, 4.5), (-1, 1.5))):
        doc.node(f"sconce_{i + 1}", "sconce", (side * (WIDE + 0.02), 1.85, z), -90 * side)
        burning(f"lamp_aisle_{i + 1}", (side * (WIDE - 0.24), 2.17, z), "aisles", 4.5, 8.0, "baked")


def dynamic_objects(doc):
    for name, material in (("figure_cloak", "cloak"), ("figure_robe", "robe")):
        doc.mesh(name, [(parts.figure(), material, 1.0)], crease=50)
    doc.mesh("stool", [(m.cylinder(0.19, 0.05, 28, 0.012).moved(0, 0.42, 0), "wood", 1.25)] +
             [(m.bar((0.09 * c, 0.44, 0.09 * s), (0.16 * c, 0.0, 0.16 * s), 0.02, 10), "wood", 1.25) for c, s in ((1, 1), (1, -1), (-1, 1), (-1, -1))])
    doc.node("dynamic_figure_aisle", "figure_cloak", (3.5, 0, -2.4), -60, extras=dict(DYNAMIC))
    doc.node("dynamic_figure_chancel", "figure_robe", (0.95, 0.17, -4.85), 170, extras=dict(DYNAMIC))
    doc.node("dynamic_stool_fire", "stool", (-3.0, 0, -2.5), 20, extras=dict(DYNAMIC))
    doc.node("dynamic_stool_aisle", "stool", (3.7, 0, 0.6), 50, extras=dict(DYNAMIC))


def cameras(doc):
    doc.camera("nave", (0.75, 1.75, 6.9), (-0.45, 2.25, -6.0), 58)
    doc.camera("hearth", (-0.9, 1.6, -1.9), (-4.6, 1.05, -3.2), 55)
    doc.camera("aisle", (3.7, 1.7, 6.2), (2.9, 1.6, -4.0), 58)


def make():
    doc = gltf.Document("Halflight scripts/make_chapel.py")
    doc.scene("chapel", {"halflight_sky_zenith": [2.6, 4.0, 7.5], "halflight_sky_horizon": [10.0, 7.5, 5.5], "halflight_sky_ground": [1.4, 1.1, 0.9],
                         "halflight_sky_changes": 1})
    materials(doc)
    for build in (floors, walls, vaults, windows, furniture, hearth, lights, dynamic_objects, cameras):
        build(doc)
    doc.scale_lightmaps(LIGHTMAP_SCALE)
    return doc


if __name__ == "__main__":
    gltf.write_showcase("chapel", make)
