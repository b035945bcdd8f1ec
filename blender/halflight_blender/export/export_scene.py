# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as Halflight reads it: Blender's own glTF exporter, and what that leaves out.

Units, stated once: the exporter turns watts into candela and lux by 683 lm/W ("Standard") or leaves them ("Unitless").
Emission and the sky, which it leaves as they are, are multiplied by the same factor here.
"""

import os

import addon_utils
import bpy

from . import area_lights, lamps, material_pictures, scene_copy, sky, surfaces
from ..glb import Glb

LUMENS_PER_WATT = 683.0

# Whatever the boxes of the exporter's own dialog say. Options that a version of it does not have are left out.
OPTIONS = {
    "export_format": "GLB",
    "export_texcoords": True,
    "export_normals": True,
    "export_tangents": False,
    "export_materials": "EXPORT",
    "export_image_format": "AUTO",
    "export_colors": True,
    "export_cameras": True,
    "export_lights": True,
    "export_extras": True,
    "export_yup": True,
    "export_apply": True,
    "export_animations": True,
    "export_current_frame": True,
    "export_rest_position_armature": False,
    "export_skins": True,
    "export_morph": True,
    "export_draco_mesh_compression_enable": False,
    "export_gpu_instances": False,
    "use_selection": False,
    "use_visible": False,
    "use_renderable": True,
    "use_active_collection": False,
    "use_active_scene": True,
    "use_mesh_edges": False,
    "use_mesh_vertices": False,
    "will_save_settings": False,
}
LIGHTING_MODES = ("export_import_convert_lighting_mode", "convert_lighting_mode")


def lumens_per_watt(units):
    return LUMENS_PER_WATT if units == "SPEC" else 1.0


def export_scene(context, path, units, folder):
    """Writes the window's scene to `path`, other files to `folder`. Returns sentences about what was left out."""
    addon_utils.enable("io_scene_gltf2")
    for item in context.scene.objects:
        if item.mode == "EDIT":
            item.update_from_editmode()
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    options = {name: value for name, value in OPTIONS.items() if name in known}
    options.update({name: units for name in LIGHTING_MODES if name in known})
    settings = context.scene.halflight
    with scene_copy.copied_scene(context) as copy:
        if settings.bake_materials:
            pictures = material_pictures.Pictures(settings.material_size)
            copy.pictures = pictures.made
            pictures.bake(context, copy.copies)
        bpy.ops.export_scene.gltf(filepath=path, check_existing=False, **options)
        document = Glb(path)
        scene_copy.restore_names(document, copy)

    factor = lumens_per_watt(units)
    surfaces.add_default(document)
    surfaces.split_specular(document)
    surfaces.drop_unread_colors(document)
    scale_emission(document, factor)
    held = lamps.held_lamps(context.scene)
    lamps.complete(document, factor, held)
    warnings = area_lights.add_lights(document, factor, held)
    extras = document.json["scenes"][document.json.get("scene", 0)].setdefault("extras", {})
    extras.pop("halflight", None)  # settings of the bake, which are not the file's
    extras["halflight_emission_unit"] = "nits"  # it is scaled: the exporter's own files carry the same generator
    warnings += sky.add_sky(context, extras, factor, folder)
    temporary = path + ".part"
    document.write(temporary)
    os.replace(temporary, path)
    return warnings


def scale_emission(document, factor):
    for material in document.json.get("materials", []):
        if not any(material.get("emissiveFactor", ())):
            continue
        extension = material.setdefault("extensions", {}).setdefault("KHR_materials_emissive_strength", {})
        extension["emissiveStrength"] = extension.get("emissiveStrength", 1.0) * factor
        document.use_extension("KHR_materials_emissive_strength")
