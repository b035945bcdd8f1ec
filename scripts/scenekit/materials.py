"""The courtyard's materials, with their painted textures."""

from . import texture


def materials(doc):
    t = {name: doc.texture(make(), name) for name, make in (
        ("plaster", texture.plaster), ("limestone", texture.limestone), ("checker", texture.checker),
        ("terracotta", texture.terracotta), ("wood", texture.wood),
        ("pine", lambda: texture.wood((168, 122, 74), (214, 170, 112), 64)))}
    color, normal = texture.paving()
    t["paving"], t["paving_normal"] = doc.texture(color, "paving"), doc.texture(normal, "paving_normal")
    for name, picture in (("leaf", texture.foliage(256, 71, (62, 98, 40), (128, 154, 70), 21, 0.27, 0.075)),
                          ("bloom", texture.foliage(128, 72, (190, 36, 112), (238, 104, 168), 25, 0.17, 0.13)),
                          ("olive", texture.foliage(256, 73, (92, 112, 72), (164, 172, 126), 33, 0.23, 0.034))):
        t[name] = doc.texture(picture, name, repeat=False)
    doc.material("plaster", texture=t["plaster"], roughness=0.95)
    doc.material("whitewash", (0.92, 0.94, 0.98), texture=t["limestone"], roughness=0.95)
    doc.material("stone", texture=t["limestone"], roughness=0.75)
    doc.material("paving", texture=t["paving"], normal=t["paving_normal"], roughness=0.7)
    doc.material("checker", texture=t["checker"], roughness=0.45)
    doc.material("terracotta", texture=t["terracotta"], roughness=0.85)
    doc.material("wood", texture=t["wood"], roughness=0.7)
    doc.material("crate", texture=t["pine"], roughness=0.75)
    doc.material("shutter", (0.09, 0.27, 0.25), roughness=0.6)
    doc.material("iron", (0.05, 0.05, 0.055), roughness=0.55, metallic=0.3)
    doc.material("wax", (0.9, 0.85, 0.7), roughness=0.6)
    doc.material("water", (0.05, 0.2, 0.23), roughness=0.08)
    doc.material("soil", (0.09, 0.06, 0.04), roughness=1.0)
    doc.material("rug", (0.45, 0.09, 0.08), roughness=1.0)
    doc.material("panel", (0.9, 0.8, 0.65), roughness=0.8, emissive=(1.0, 0.6, 0.27), strength=2.4)
    doc.material("flame", (1.0, 0.8, 0.5), roughness=1.0, emissive=(1.0, 0.6, 0.22), strength=9.0)
    for name in ("leaf", "bloom", "olive"):
        doc.material(name, texture=t[name], roughness=0.8, mask=0.5, double_sided=True)
    doc.material("red", (0.62, 0.06, 0.04), roughness=0.35)
    doc.material("blue", (0.05, 0.16, 0.5), roughness=0.35)
    doc.material("ochre", (0.78, 0.44, 0.07), roughness=0.4)
    doc.material("ivory", (0.82, 0.78, 0.7), roughness=0.3)
    doc.material("jade", (0.07, 0.4, 0.22), roughness=0.3)
    doc.material("brass", (0.88, 0.62, 0.26), roughness=0.35, metallic=0.85)
    doc.material("maple", (0.72, 0.46, 0.24), roughness=0.5)
