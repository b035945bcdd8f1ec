"""Documents of the tests' scenes, and rooms whose light takes colour from glass or is of groups."""

from . import gltf, mesh as m
from .mesh import Mesh

MIXED = {"halflight_mode": "mixed"}
DYNAMIC = {"halflight_static": 0}


MATERIALS = {"grey": ((0.5, 0.5, 0.5), 1.0), "white": ((0.8, 0.8, 0.8), 1.0), "red": ((0.6, 0.1, 0.08), 0.6),
             "slate": ((0.22, 0.23, 0.25), 0.3), "steel": ((0.75, 0.75, 0.78), 0.25, 1.0)}


def document(name, materials, sky=None):
    doc = gltf.Document("Halflight scripts/make_test_scenes.py")
    extras = {f"halflight_sky_{part}": color for part, color in zip(("zenith", "horizon", "ground"), sky)} if sky else None
    doc.json["scenes"][0]["name"] = name
    for material in materials:
        doc.material(material, *MATERIALS[material])
    if extras:
        doc.json["scenes"][0]["extras"] = extras
    return doc


def glass(doc, name, color, alpha=1.0, **more):
    doc.material(name, color, 0.3, double_sided=not more.get("volume"))
    material = doc.json["materials"][-1]
    if alpha < 1.0:
        material.update(alphaMode="BLEND", extras={"halflight_tinted": 1})
        material["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha
        return
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    if more.get("volume"):
        extensions["KHR_materials_volume"] = more["volume"]
    material["extensions"] = extensions
    doc.used.update(extensions)


def coloured_glass():
    """A room with three windows under a white sun and sky: a red tinted film, a blue pane with transmission, a green volume."""
    doc = document("coloured_glass", ("white",), ([1.5] * 3,) * 3)
    glass(doc, "film", (0.9, 0.1, 0.05), alpha=0.2)
    glass(doc, "pane", (0.1, 0.25, 0.9))
    glass(doc, "block", (1, 1, 1), volume={"thicknessFactor": 0.1, "attenuationDistance": 0.1, "attenuationColor": [0.15, 0.8, 0.25]})
    shell = [m.box(-2.2, -0.2, -2.7, 2.3, 0, 2.7), m.box(-2.2, 3, -2.7, 2.3, 3.2, 2.7), m.box(-2.2, 0, -2.7, -2, 3, 2.7),
             m.box(-2, 0, -2.7, 2.3, 3, -2.5), m.box(-2, 0, 2.5, 2.3, 3, 2.7), m.box(2, 0, -2.5, 2.3, 0.8, 2.5),
             m.box(2, 2.4, -2.5, 2.3, 3, 2.5)]
    places = (-1.4, 0.0, 1.4)
    edges = [-2.5] + [z + side for z in places for side in (-0.5, 0.5)] + [2.5]
    shell += [m.box(2, 0.8, a, 2.3, 2.4, b) for a, b in zip(edges[::2], edges[1::2])]
    for i, mesh in enumerate(shell):
        doc.mesh(f"wall_{i + 1}", [(mesh, "white", 1.0)])
        doc.node(f"wall_{i + 1}", f"wall_{i + 1}")
    for name, z in (("film", places[0]), ("pane", places[1])):
        sheet = Mesh([(((2.15, 0.8, z + 0.5), (2.15, 0.8, z - 0.5), (2.15, 2.4, z - 0.5)), ((0, 0), (1, 0), (1, 1))),
                      (((2.15, 0.8, z + 0.5), (2.15, 2.4, z - 0.5), (2.15, 2.4, z + 0.5)), ((0, 0), (1, 1), (0, 1)))])
        doc.mesh(name, [(sheet, name, 1.0)], closed=False)
        doc.node(name, name, extras={"halflight_lightmap_scale": 0})
    doc.mesh("block", [(m.box(2.1, 0.802, places[2] - 0.498, 2.2, 2.398, places[2] + 0.498), "block", 1.0)])
    doc.node("block", "block", extras={"halflight_lightmap_scale": 0})
    doc.mesh("post", [(m.box(-0.3, 0, -0.3, 0.3, 0.9, 0.3), "white", 1.0)])
    doc.node("post", "post", (-0.6, -0.005, -0.1))
    doc.light("sun", "directional", (1, 1, 1), 40.0, (8.0, 6.2, 1.8), (0, 0, 0),
              extras={"halflight_mode": "baked", "halflight_angular_diameter": 0.5})
    doc.camera("main", (-1.4, 1.7, 2.2), (0.5, 0.8, -1.0), 57)
    doc.camera("floor", (-0.3, 2.7, 0.0), (0.0, 0.0, 0.0), 57)  # what passes, without the glass
    return doc


def light_groups(name="light_groups"):
    """Two rooms with a window each: sun and sky are light groups, and so are a lamp and the strips of each room, of one material."""
    doc = document(name, ("white", "red", "grey"), ([2.0, 2.6, 4.0], [2.4, 2.6, 3.0], [0.6, 0.5, 0.4]))
    doc.material("neon", (0.1, 0.1, 0.1), 1.0, emissive=(1.0, 0.73, 0.47), strength=30.0)
    shell = [m.box(-4.2, -0.2, -2.2, 4.2, 0, 2.2), m.box(-4.2, 2.6, -2.2, 4.2, 2.8, 2.2), m.box(-4.2, 0, -2.2, 4.2, 2.6, -2),
             m.box(-4.2, 0, -2, -4, 2.6, 2.2), m.box(4, 0, -2, 4.2, 2.6, 2.2), m.box(-0.1, 0, -2, 0.1, 2.6, 2)]
    shell += [m.box(a, y, 2, b, top, 2.2) for a, b, y, top in
              ((-4, 4, 0, 0.8), (-4, 4, 2.2, 2.6), (-4, -3, 0.8, 2.2), (-1.6, 1.6, 0.8, 2.2), (3, 4, 0.8, 2.2))]
    for i, wall in enumerate(shell):
        doc.node(f"wall_{i}", doc.mesh(f"wall_{i}", [(wall, "red" if i == 5 else "white", 1.0)]) or f"wall_{i}")
    doc.mesh("strip", [(m.box(-0.6, -0.03, -0.05, 0.6, 0.03, 0.05), "neon", 1.0)])
    doc.mesh("post", [(m.box(-0.3, 0, -0.3, 0.3, 1.0, 0.3), "grey", 1.0)])
    for room, x in (("west", -2.1), ("east", 2.1)):
        doc.node(f"strip_{room}", "strip", (x, 2.0, -1.93), extras={"halflight_group": room})
        doc.node(f"post_{room}", "post", (x + 0.6, -0.005, -0.4))
    doc.light("lamp", "point", (1.0, 0.1, 0.05), 6.0, (-3.2, 1.6, 0.6), None, cone_range=6.0, extras={**MIXED, "halflight_group": "lamp"})
    doc.light("candle", "point", (1.0, 0.7, 0.4), 0.3, (3.2, 0.6, -1.2), cone_range=5.0, extras={"halflight_mode": "baked"})
    doc.light("sun", "directional", (1, 0.95, 0.85), 40.0, (3, 5, 6), (0, 0, 0), extras={"halflight_mode": "baked", "halflight_group": "sun"})
    doc.camera("main", (-0.5, 1.7, 1.7), (-2.9, 0.8, -1.2), 75)
    doc.json["scenes"][0]["extras"]["halflight_sky_group"] = "day"
    return doc


def metal_rooms():
    """The same rooms of metal, under a sky that changes: what one sees of the groups is in reflection probes."""
    doc = light_groups("metal_rooms")
    extras = doc.json["scenes"][0]["extras"]
    del extras["halflight_sky_group"]
    extras["halflight_sky_changes"] = 1
    for material in doc.json["materials"]:
        material["pbrMetallicRoughness"].update(metallicFactor=1.0, roughnessFactor=0.3)
    return doc
