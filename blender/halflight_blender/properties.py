# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as proper properties.

Those of objects, lights, materials and scenes are custom properties with the documented names (docs/format.md,
"Settings in source files"): the glTF exporter writes them as extras, with or without this extension. A property at its
default is not stored. Settings of the bake itself are in Scene.halflight.
"""

import bpy

from .export import material_pictures
from .groups import state


def store(owner, key, value, default):
    if value == default:
        if key in owner:
            del owner[key]
    else:
        owner[key] = value


def extra_bool(key, name, description, default=True):
    return bpy.props.BoolProperty(
        name=name,
        description=description,
        default=default,
        get=lambda owner: bool(owner.get(key, default)),
        set=lambda owner, value: store(owner, key, int(value), int(default)),
    )


def extra_float(key, name, description, default, **limits):
    return bpy.props.FloatProperty(
        name=name,
        description=description,
        default=default,
        get=lambda owner: float(owner.get(key, default)),
        set=lambda owner, value: store(owner, key, round(value, 6), default),
        **limits,
    )


def extra_name(key, name, description):
    return bpy.props.StringProperty(
        name=name,
        description=description,
        maxlen=64,
        get=lambda owner: str(owner.get(key, "")),
        set=lambda owner, value: store(owner, key, value, ""),
    )


def extra_choice(key, name, description, items):
    """items: (value of the extra, name, tooltip); None is "not stored"."""
    values = [item[0] for item in items]
    default = values.index(None) if None in values else 0

    def get(owner):
        value = owner.get(key)
        return values.index(value) if value in values else default

    return bpy.props.EnumProperty(
        name=name,
        description=description,
        items=[(label.upper().replace(" ", "_"), label, tip, i) for i, (value, label, tip) in enumerate(items)],
        get=get,
        set=lambda owner, i: store(owner, key, values[i], values[default]),
    )


def extra_vector(factory, key, name, description, **limits):
    """All zero is "not stored"."""
    none = [0, 0, 0]
    return factory(
        name=name,
        description=description,
        size=3,
        get=lambda owner: list(owner.get(key, none)),
        set=lambda owner, value: store(owner, key, list(value), none),
        **limits,
    )


STATIC_ITEMS = [
    (None, "By Animation", "Static unless animated or skinned, or a parent says otherwise"),
    (1, "Static", "Gets lightmap texels and takes part in the bake; so do its children"),
    (0, "Dynamic", "Lit by probes and real-time lights; so are its children"),
]
SIDE_ITEMS = [
    (None, "By Light", "Texels for both sides of a sheet where both can be seen and their light differs"),
    (1, "Both", "Texels for each side of double-sided sheets"),
    (0, "One", "One texel for both sides"),
]
PROBE_ITEMS = [
    (None, "By Size", "One probe sample for small objects, a volume for large ones"),
    ("single", "One Sample", "Light of the probes at its middle"),
    ("volume", "Volume", "A proxy volume: light differs over the object"),
]
LIGHT_ITEMS = [
    ("mixed", "Mixed", "Shines at run time; its bounced light and its static shadows are baked"),
    ("baked", "Baked", "All of its light is in the lightmap; costs nothing at run time"),
    ("realtime", "Realtime", "Not baked at all"),
]

CASTS = "Throws shadows, in the bake and at run time"
RECEIVES = "Receives shadows, in the bake and at run time"


def extra_group(whose):
    return extra_name(
        "halflight_group",
        "Light Group",
        f"{whose}. The bake keeps the light of each group by itself, so that it can be dimmed and recoloured afterwards",
    )


EXTRAS = {
    bpy.types.Object: {
        "halflight_static": extra_choice(
            "halflight_static", "Lighting", "Whether the object's light is baked", STATIC_ITEMS
        ),
        "halflight_cast_shadows": extra_bool("halflight_cast_shadows", "Cast Shadows", CASTS),
        "halflight_receive_shadows": extra_bool("halflight_receive_shadows", "Receive Shadows", RECEIVES),
        "halflight_lightmap_scale": extra_float(
            "halflight_lightmap_scale",
            "Lightmap Scale",
            "Factor on the texels per metre; 0 casts into the bake and gets no texels",
            1.0,
            min=0.0,
            max=1000.0,
            soft_max=8.0,
        ),
        "halflight_two_sided": extra_choice(
            "halflight_two_sided", "Sides", "Which sides of sheets such as boards and curtains get texels", SIDE_ITEMS
        ),
        "halflight_probes": extra_choice(
            "halflight_probes", "Probe Light", "How an object without lightmap takes the probes' light", PROBE_ITEMS
        ),
        "halflight_probe_resolution": extra_vector(
            bpy.props.IntVectorProperty,
            "halflight_probe_resolution",
            "Volume Texels",
            "Texels of its proxy volume along X, Y and Z of the exported object; 0 by the distance of probes",
            min=0,
            max=64,
        ),
        "halflight_group": extra_group("Group of the lamps and glowing surfaces of the object and its children"),
    },
    bpy.types.Collection: {
        "halflight_group": extra_group("Group of the lamps and glowing surfaces of objects that have no group of their own"),
    },
    bpy.types.Material: {
        "halflight_group": extra_group("Group of the material's emission, where its object has none"),
        "halflight_cast_shadows": extra_bool("halflight_cast_shadows", "Cast Shadows", CASTS),
        "halflight_receive_shadows": extra_bool("halflight_receive_shadows", "Receive Shadows", RECEIVES),
    },
    bpy.types.Light: {
        "halflight_group": extra_group("Group of the lamp"),
        "halflight_mode": extra_choice("halflight_mode", "Mode", "What of the light is baked", LIGHT_ITEMS),
        "halflight_cast_shadows": extra_bool("halflight_cast_shadows", "Cast Shadows", "The light throws shadows"),
        "halflight_shadow_strength": extra_float(
            "halflight_shadow_strength",
            "Shadow Strength",
            "1: shadows are as dark as they are; 0: none",
            1.0,
            min=0.0,
            max=1.0,
            subtype="FACTOR",
        ),
        "halflight_indirect_multiplier": extra_float(
            "halflight_indirect_multiplier",
            "Indirect Multiplier",
            "Factor on the light's bounced light",
            1.0,
            min=0.0,
            soft_max=4.0,
        ),
        "halflight_depth_bias": extra_float(
            "halflight_depth_bias", "Depth Bias", "Of its real-time shadow map, in texels", 0.1, min=0.0, max=100.0
        ),
        "halflight_slope_bias": extra_float(
            "halflight_slope_bias", "Slope Bias", "Of its real-time shadow map, by the slope", 1.5, min=0.0, max=100.0
        ),
        "halflight_normal_bias": extra_float(
            "halflight_normal_bias", "Normal Bias", "Of its real-time shadow map, in texels", 1.2, min=0.0, max=8.0
        ),
    },
    bpy.types.Scene: {
        "halflight_shadow_color": extra_vector(
            bpy.props.FloatVectorProperty,
            "halflight_shadow_color",
            "Shadow Color",
            "Subtractive mode: irradiance in lux below which dynamic shadows do not go; black leaves it to the bake",
            min=0.0,
            soft_max=1000.0,
        ),
        "halflight_sky_group": extra_name("halflight_sky_group", "Light Group", "Group of the sky's light"),
        "halflight_sky_changes": extra_bool(
            "halflight_sky_changes",
            "Sky Changes",
            "Zenith, horizon and ground are light groups, sky.zenith, sky.horizon and sky.ground; a picture is sky.picture",
            False,
        ),
    },
}

WORLD_SKY = bpy.props.EnumProperty(
    name="Sky",
    description="What the bake takes for the sky",
    items=[
        ("WORLD", "This World", "Colour, environment picture, or a panorama of any other world shader"),
        ("NONE", "None", "Black: light comes from lamps and emissive surfaces alone"),
    ],
)
WORLD_WIDTH = bpy.props.IntProperty(
    name="Panorama Width",
    description="Texels of the panorama that is rendered of a world that is neither a colour nor a plain picture",
    default=1024,
    min=64,
    max=8192,
)


class BakedObject(bpy.types.PropertyGroup):
    """An object of the last bake. Its name here is that in the file; the object itself may have got another since."""

    item: bpy.props.PointerProperty(type=bpy.types.Object)


class BakeSettings(bpy.types.PropertyGroup):
    mode: bpy.props.EnumProperty(
        name="Mode",
        description="What the shadows of mixed lights are made of",
        items=[
            ("shadowmask", "Shadowmask", "Static shadows are baked in masks, up to four lights at any place"),
            ("baked-indirect", "Baked Indirect", "Bounced light is baked; all shadows of mixed lights are real-time"),
            ("subtractive", "Subtractive", "All light on static objects is baked; cheapest"),
        ],
    )
    quality: bpy.props.EnumProperty(
        name="Quality",
        description="Samples, density and page size in one word",
        items=[
            ("preview", "Preview", "32 rays per texel, pages of 1024 texels"),
            ("medium", "Medium", "96 rays per texel, pages of 2048 texels"),
            ("high", "High", "256 rays per texel, pages of 4096 texels"),
            ("ultra", "Ultra", "1024 rays per texel, pages of 4096 texels"),
        ],
        default="medium",
    )
    texels_per_meter: bpy.props.FloatProperty(
        name="Texels per Meter",
        description="Lightmap density. 0: what fits one page. A density given keeps the layout, so that a changed "
        "scene is re-baked only where the change shows",
        min=0.0,
        max=10000.0,
        soft_max=100.0,
    )
    lightmap_size: bpy.props.IntProperty(name="Page Size", description="0: by quality", min=0, max=8192)
    samples: bpy.props.IntProperty(name="Rays", description="Per texel. 0: by quality", min=0, max=1 << 20)
    shadow_samples: bpy.props.IntProperty(
        name="Shadow Rays", description="Per texel and light. 0: by quality", min=0, max=1 << 16
    )
    noise: bpy.props.FloatProperty(
        name="Noise",
        description="Noise in percent at which a texel has enough rays. 0: a number of rays instead",
        min=0.0,
        max=100.0,
        subtype="PERCENTAGE",
    )
    bounces: bpy.props.IntProperty(name="Bounces", description="-1: all light", default=-1, min=-1, max=256)
    denoise: bpy.props.BoolProperty(name="Denoise", default=True)
    glossy_bounces: bpy.props.BoolProperty(
        name="Glossy Bounces",
        description="Gloss and metal carry light on as glTF has it. Off: all surfaces as diffuse ones",
        default=True,
    )
    directional: bpy.props.BoolProperty(
        name="Directional",
        description="Keep mean directions, so that normal maps respond to baked light. The baked view here shows none, "
        "so this is off, whatever the quality is",
    )
    integrator: bpy.props.EnumProperty(
        name="Integrator",
        items=[
            ("cache", "Radiance Cache", "Rays end in light that is known already"),
            ("path", "Path Tracing", "Whole unbiased paths; slow, to check by"),
        ],
    )
    two_sided: bpy.props.EnumProperty(
        name="Sides",
        description="Which sides of sheets such as boards and curtains get texels, where the object does not say it",
        items=[
            ("auto", "By Light", "Both where both can be seen and their light differs"),
            ("on", "Both", "Each side of double-sided sheets"),
            ("off", "One", "One texel for both sides"),
        ],
    )
    shadowmask_encoding: bpy.props.EnumProperty(
        name="Mask",
        items=[
            ("attenuation", "Attenuation", "Texels hold how much light arrives"),
            ("distance-field", "Distance Field", "Texels hold the distance to the shadow's edge: crisp hard edges"),
        ],
    )
    groups: bpy.props.EnumProperty(
        name="Light Groups",
        items=[
            ("authored", "By Name", "Lamps, objects, materials and the sky that name a group"),
            ("each", "Each", "Every lamp and glowing material is a group of its own, up to 16"),
            ("off", "None", "All light is baked in one"),
        ],
    )
    probe_layout: bpy.props.EnumProperty(
        name="Probes",
        items=[
            ("refined", "Refined", "Probes where light changes, and on floors"),
            ("grid", "Grid", "A regular grid, for engines that read nothing else"),
        ],
    )
    probe_spacing: bpy.props.FloatProperty(
        name="Probe Spacing", description="0: by the scene's size", min=0.0, soft_max=10.0, subtype="DISTANCE"
    )
    bake_materials: bpy.props.BoolProperty(
        name="Bake Materials",
        description="Nodes that glTF lacks become pictures in the exported file. Your materials are not changed",
    )
    material_size: bpy.props.IntProperty(
        name="Picture Size", description="Texels of each of these pictures, along each side", default=1024, min=16, max=8192
    )
    device: bpy.props.EnumProperty(
        name="Device",
        description="What traces the rays. A GPU gathers the lightmap's light and denoises it",
        items=[
            ("auto", "Automatic", "A GPU where it is expected to be quicker"),
            ("cpu", "Processor", "The processor alone: the same bytes on all machines of one kind"),
            ("gpu", "GPU", "The best GPU that traces rays by Vulkan"),
        ],
    )
    threads: bpy.props.IntProperty(name="Threads", description="0: all cores", min=0, max=4096)
    seed: bpy.props.IntProperty(name="Seed", description="Of the random numbers", default=1, min=0)
    units: bpy.props.EnumProperty(
        name="Units",
        description="Of the lights in the file. Emission and sky go with them",
        items=[
            ("SPEC", "Standard", "Candela, lux and nits, as glTF has it: 1 W is 683 lm"),
            ("COMPAT", "Unitless", "Blender's numbers, for viewers without exposure"),
        ],
    )
    output: bpy.props.StringProperty(
        name="Save As", description="The baked .glb is copied here as well", subtype="FILE_PATH"
    )
    show_view: bpy.props.BoolProperty(
        name="Show When Done", description="Switch to the baked view after the bake", default=True
    )
    baked_digest: bpy.props.StringProperty(options={"HIDDEN"})
    summary: bpy.props.StringProperty(options={"HIDDEN"})
    folder: bpy.props.StringProperty(options={"HIDDEN"})  # of its files; set by its first bake
    view_of: bpy.props.PointerProperty(type=bpy.types.Scene, options={"HIDDEN"})
    baked_objects: bpy.props.CollectionProperty(type=BakedObject, options={"HIDDEN"})
    light_groups: bpy.props.CollectionProperty(type=state.LightGroup)

    def has_pictures(self, item, material):
        """Whether this bake makes pictures of a material on an object."""
        return self.bake_materials and material_pictures.can_bake(item) and material_pictures.is_curable(material)


CLASSES = (BakedObject, state.GroupMember, state.LightGroup, BakeSettings)


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)
    for owner, properties in EXTRAS.items():
        for name, definition in properties.items():
            setattr(owner, name, definition)
    bpy.types.World.halflight_sky_source = WORLD_SKY
    bpy.types.World.halflight_sky_width = WORLD_WIDTH
    bpy.types.Scene.halflight = bpy.props.PointerProperty(type=BakeSettings)


def unregister():
    del bpy.types.Scene.halflight
    del bpy.types.World.halflight_sky_width
    del bpy.types.World.halflight_sky_source
    for owner, properties in EXTRAS.items():
        for name in properties:
            delattr(owner, name)
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
