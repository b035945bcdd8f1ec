"""The part of compare_cycles.py that runs inside of Blender: bakes with Cycles, and compares pictures.

    blender -b --python-exit-code 1 --python cycles_in_blender.py -- bake SCENE OUT.npy --samples N [--seed N]
    blender -b --python-exit-code 1 --python cycles_in_blender.py -- compare JOB.json

A bake prints the processor's seconds of the bake alone, of all threads. Pictures are arrays of height, width and RGBA,
scene-linear, bottom row first. Cycles' texels are irradiance / pi, and alpha is 1 where a triangle lies.
"""

import argparse
import json
import math
import pathlib
import resource
import sys

import bpy
import numpy

SIZE = 512
BOUNCES = 4
SUN_ENERGY = math.pi  # W/m2: Cycles' texels are then a share of the sun's light
SUN_DEGREES = 0.526
LUMINANCE = (0.2126, 0.7152, 0.0722)

BLACK = 0.003  # of the reference: texels below are buried, or no light reaches them
EDGE_WIDTH = 2  # texels around buried ones, charts' borders and the sun's edges


def cpu_seconds():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


# Baking with Cycles.


def diffuse_material(material, image):
    """Makes a material diffuse alone, lit from its front only where it emits, and the image its target."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    principled = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    color = tuple(principled.inputs["Base Color"].default_value)
    emission = tuple(principled.inputs["Emission"].default_value)
    strength = principled.inputs["Emission Strength"].default_value
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    surface = nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs["Color"].default_value = color
    if strength * max(emission[:3]) > 0:
        light, both = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeAddShader")
        front, facing = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeNewGeometry")
        front.operation = "MULTIPLY_ADD"
        front.inputs[1].default_value, front.inputs[2].default_value = -strength, strength
        light.inputs["Color"].default_value = emission
        links.new(facing.outputs["Backfacing"], front.inputs[0])
        links.new(front.outputs[0], light.inputs["Strength"])
        links.new(light.outputs[0], both.inputs[0])
        links.new(surface.outputs[0], both.inputs[1])
        surface = both
    links.new(surface.outputs[0], output.inputs["Surface"])
    target = nodes.new("ShaderNodeTexImage")
    target.image = image
    nodes.active = target


def set_cycles(scene, samples, seed):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_fast_gi = False
    cycles.max_bounces = cycles.diffuse_bounces = BOUNCES
    cycles.glossy_bounces = cycles.transmission_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0


def bake(arguments):
    numpy.bool = bool  # Blender 3.4's importer uses a name that newer numpy lacks
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=arguments.scene)
    # Without "Linear" the pixels would be sRGB-encoded, though they are floats.
    image = bpy.data.images.new("lightmap", SIZE, SIZE, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Linear"
    for material in bpy.data.materials:
        diffuse_material(material, image)
    for light in bpy.data.lights:
        light.energy, light.angle = SUN_ENERGY, math.radians(SUN_DEGREES)
        light.cycles.cast_shadow = not arguments.no_shadows
    mesh = next(thing for thing in bpy.data.objects if thing.type == "MESH")
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = mesh
    mesh.select_set(True)
    set_cycles(bpy.context.scene, arguments.samples, arguments.seed)
    light = {"DIRECT"} if arguments.direct else {"DIRECT", "INDIRECT"}
    before = cpu_seconds()
    bpy.ops.object.bake(type="DIFFUSE", pass_filter=light, margin=0, uv_layer=mesh.data.uv_layers[1].name)
    print(f"cpu seconds {cpu_seconds() - before:.3f}")
    numpy.save(arguments.output, pixels_of(image))


def pixels_of(image):
    pixels = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


# Comparing.


def luminance(picture):
    return picture[..., :3].astype(numpy.float64) @ numpy.array(LUMINANCE)


def grown(mask, width):
    """A mask and what is within so many texels of it."""
    padded = numpy.pad(mask, width)
    height, across = mask.shape
    shifts = [(y, x) for y in range(2 * width + 1) for x in range(2 * width + 1)]
    return numpy.any([padded[y : y + height, x : x + across] for y, x in shifts], axis=0)


def sun_edges(shadowed, unshadowed, covered):
    """Texels where the sun is partly hidden, or that are lit beside one that is not."""
    share = luminance(shadowed) / numpy.maximum(luminance(unshadowed), 1e-6)
    faces_sun = covered & (luminance(unshadowed) > 1e-3)
    edges = faces_sun & (share > 0.02) & (share < 0.98)
    lit = faces_sun & (share >= 0.5)
    for axis in (0, 1):
        change = numpy.diff(lit.astype(numpy.int8), axis=axis) != 0
        change = change & numpy.take(covered, range(1, SIZE), axis) & numpy.take(covered, range(SIZE - 1), axis)
        before, after = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        before[axis], after[axis] = (0, 1), (1, 0)
        edges |= numpy.pad(change, before) | numpy.pad(change, after)
    return edges


def compared_texels(job, reference, covered):
    """Those that are compared, and those of them that are not close to black ones and to charts' borders."""
    lit = covered & (luminance(reference) > BLACK)
    away = lit & ~grown(~lit, EDGE_WIDTH)
    if "shadowed" not in job:
        return lit, away
    edges = sun_edges(numpy.load(job["shadowed"]), numpy.load(job["unshadowed"]), covered)
    away &= ~grown(edges, EDGE_WIDTH)
    return away, away


def picture(path):
    """Cycles' array; or Halflight's EXR, which is irradiance in lux."""
    if pathlib.Path(path).suffix == ".npy":
        return numpy.load(path)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Linear"
    return pixels_of(image) / math.pi


def relative_error(off, noise, mean):
    """Root mean square without the reference's own noise, over the mean."""
    return math.sqrt(max(numpy.mean(off**2) - noise, 0)) / mean


def compare(arguments):
    """Differences of luminance from the reference, the mean of its parts."""
    job = json.loads(pathlib.Path(arguments.job).read_text())
    parts = [numpy.load(path) for path in job["reference"]]
    values = numpy.array([luminance(part) for part in parts])
    truth, variance = values.mean(axis=0), values.var(axis=0, ddof=1) / len(parts)
    texels, away = compared_texels(job, numpy.mean(parts, axis=0), parts[0][..., 3] > 0.5)
    mean, noise, noise_away = truth[texels].mean(), variance[texels].mean(), variance[away].mean()
    result = {"texels": int(texels.sum()), "texelsAway": int(away.sum()), "referenceNoise": math.sqrt(noise) / mean}
    result["pictures"] = {}
    for path in job["pictures"]:
        off = luminance(picture(path)) - truth
        result["pictures"][path] = {
            "error": relative_error(off[texels], noise, mean),
            "errorAway": relative_error(off[away], noise_away, truth[away].mean()),
            "bias": off[texels].mean() / mean,
        }
    pathlib.Path(job["result"]).write_text(json.dumps(result, indent=2))


def main():
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True)
    baking = commands.add_parser("bake")
    baking.add_argument("scene")
    baking.add_argument("output")
    baking.add_argument("--samples", type=int, required=True)
    baking.add_argument("--seed", type=int, default=0)
    baking.add_argument("--direct", action="store_true", help="direct light alone")
    baking.add_argument("--no-shadows", action="store_true", help="of the sun")
    baking.set_defaults(run=bake)
    comparing = commands.add_parser("compare")
    comparing.add_argument("job")
    comparing.set_defaults(run=compare)
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
    arguments.run(arguments)


main()
