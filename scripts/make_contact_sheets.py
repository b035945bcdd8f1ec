#!/usr/bin/env python3
"""Draws the labelled contact sheets of docs/images/, one per part of the system, from the project's own scenes in assets/.

    scripts/make_contact_sheets.py [--halflight PROGRAM] [--only NAME,…] [--fresh] [--list]

PROGRAM is build/release/apps/halflight/halflight by default (cmake --preset release && cmake --build --preset release).
Bakes and single pictures stay in build/sheets, and bakes are used again unless --fresh. Within a sheet all pictures of light have one
exposure, chosen by its first. Needs ImageMagick and a font, which scripts/install-packages.sh brings; some ten minutes on two cores.
"""

import argparse
import hashlib
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build" / "sheets"
IMAGES = ROOT / "docs" / "images"
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
SIZE = "480x270"


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"make_contact_sheets.py: {' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


class Sheet:
    """One sheet in the making: its pictures in reading order, and the exposure they share."""

    def __init__(self, name, halflight, fresh):
        self.name, self.halflight, self.fresh = name, halflight, fresh
        self.folder = WORK / name
        self.folder.mkdir(parents=True, exist_ok=True)
        self.panels, self.exposure, self.columns = [], "auto", 3

    def bake(self, scene, *options, settings=""):
        """A baked file, named by what made it."""
        path = ROOT / "assets" / scene
        key = hashlib.sha256(path.read_bytes() + repr(options).encode() + settings.encode()).hexdigest()[:12]
        output = WORK / f"{path.stem}-{key}.glb"
        if output.exists() and not self.fresh:
            return output
        command = [self.halflight, "bake", path, "-o", output, "--quiet", *options]
        if settings:
            file = WORK / f"{path.stem}-{key}.toml"
            file.write_text(settings)
            command += ["--settings", file]
        run(*command)
        return output

    def render(self, label, baked, *options, size=SIZE):
        """Drawn at twice the size and halved, for smooth edges; a reference has them of its own."""
        picture = self.folder / f"{len(self.panels)}.png"
        drawn = size if "--reference" in options else "x".join(str(2 * int(n)) for n in size.split("x"))
        summary = json.loads(run(self.halflight, "render", baked, "-o", picture, "--size", drawn, f"--exposure={self.exposure}",
                                 "--json", *options))
        if self.exposure == "auto" and "exposure" in summary:
            self.exposure = summary["exposure"]
        if drawn != size:
            run("convert", picture, "-filter", "Box", "-resize", size, picture)
        self.panels.append((label, picture))
        return picture

    def difference(self, label, a, b, factor):
        """|a - b| of the displayed values, times a factor: black is equal."""
        picture = self.folder / f"{len(self.panels)}.png"
        run("convert", a, b, "-compose", "difference", "-composite", "-evaluate", "multiply", factor, picture)
        self.panels.append((label, picture))

    def write(self):
        labelled = [part for label, picture in self.panels for part in ("-label", label, picture)]
        target = IMAGES / f"{self.name}.jpg"
        run("montage", "-font", FONT, "-pointsize", "15", "-fill", "white", "-background", "#202024", *labelled,
            "-tile", f"{self.columns}x", "-geometry", "+6+5", "-quality", "88", "-sampling-factor", "4:4:4", "-strip", target)
        print(f"{target.relative_to(ROOT)}: {len(self.panels)} pictures, {target.stat().st_size / 1e3:.0f} kB", flush=True)


AVENUE = ("tests/avenue.glb", "--quality", "medium", "--lightmap-size", "1024", "--shadow-samples", "64")
FADE = ("--shadow-distance", "30", "--shadow-fade-range", "14")


def shadow_fade(s):
    """S1: posts left and right of a road, all shadows realtime."""
    baked = s.bake(*AVENUE)
    mode = ("--mode", "baked-indirect", "--camera", "high")
    s.render("shadow distance 80 m: all near", baked, *mode, "--shadow-distance", "80", "--shadow-fade-range", "1")
    s.render("30 m, fade range 14 m: near, fading, gone", baked, *mode, *FADE)
    s.render("the same, view fade: black 0 … white 1", baked, *mode, *FADE, "--view", "fade")
    s.render("30 m, fade range 1 m", baked, *mode, "--shadow-distance", "30", "--shadow-fade-range", "1")
    s.render("18 m, fade range 9 m", baked, *mode, "--shadow-distance", "18", "--shadow-fade-range", "9")
    s.render("the same, view fade", baked, *mode, "--shadow-distance", "18", "--shadow-fade-range", "9", "--view", "fade")


def shadowmask(s):
    """S8, S12, S19: what the mask adds. Static posts left, dynamic ones (red) right."""
    baked = s.bake(*AVENUE)
    camera = ("--camera", "high")
    s.render("no mask (baked indirect), shadow distance 12 m", baked, "--mode", "baked-indirect", *camera, "--shadow-distance", "12")
    s.render("shadowmask, 12 m: static shadows stay", baked, "--mode", "shadowmask", *camera, "--shadow-distance", "12")
    s.render("view shadowmask: cyan where channel 0, the sun, is off", baked, "--view", "shadowmask", *camera)
    s.render("only baked: shadow distance 0.5 m", baked, "--mode", "shadowmask", *camera, "--shadow-distance", "0.5")
    s.render("shadow strength 0.5, after mixing", baked, "--mode", "shadowmask", *camera, *FADE, "--light", "sun:strength=0.5")
    s.render("path traced, for comparison", baked, "--reference", "64", *camera)


def distance_shadowmask(s):
    """S12, S13: the two run-time modes of one bake."""
    baked = s.bake(*AVENUE)
    close, near = ("--camera", "close"), ("--shadow-distance", "60")
    s.render("shadowmask, near: static shadow baked", baked, "--mode", "shadowmask", *close, *near)
    s.render("distance shadowmask, near: realtime", baked, "--mode", "distance-shadowmask", *close, *near)
    s.render("distance shadowmask beyond 0.5 m: baked", baked, "--mode", "distance-shadowmask", *close, "--shadow-distance", "0.5")
    short = ("--shadow-distance", "6.5", "--shadow-fade-range", "3.5")
    s.render("shadowmask, 6.5 m, range 3.5 m", baked, "--mode", "shadowmask", *close, *short)
    s.render("distance shadowmask, the same: crisp near, soft far", baked, "--mode", "distance-shadowmask", *close, *short)
    s.render("view fade: where realtime turns into baked", baked, "--view", "fade", *close, *short)


def four_lights(s):
    """S9, S18: four masks on one surface, selected by channel."""
    baked = s.bake("tests/four_lights.glb", "--quality", "medium", "--lightmap-size", "1024", "--shadow-samples", "64")
    names = ("red", "green", "blue", "white")
    s.columns = 4
    s.render("four mixed spots, shadowmask", baked)
    s.render("path traced", baked, "--reference", "64")
    s.render("view shadowmask: R, G, B and A (darker)", baked, "--view", "shadowmask")
    s.render("view overlap: 1 blue … 4 red", baked, "--view", "overlap")
    for name in names:
        off = [part for other in names if other != name for part in ("--light", f"{other}:intensity=0")]
        s.render(f"only {name}, by its channel, static casters baked", baked, "--mode", "shadowmask", *off)


def point_masks(s):
    """S4: shadows of point lights, baked and realtime."""
    baked = s.bake("tests/two_rooms.glb", "--quality", "medium", "--lightmap-size", "1024", "--shadow-samples", "64")
    s.render("shadowmask: its mask", baked, "--mode", "shadowmask")
    s.render("distance shadowmask, realtime map", baked, "--mode", "distance-shadowmask")
    s.render("view shadowmask, west room: channel 0", baked, "--view", "shadowmask")
    s.render("view shadowmask, east room: the same channel", baked, "--view", "shadowmask", "--camera", "east")
    s.render("path traced, for comparison", baked, "--reference", "64")


HALL = ("--quality", "medium", "--lightmap-size", "1024", "--probe-spacing", "0.6")


def probes(s):
    """S14: light and occlusion probes on dynamic objects."""
    baked = s.bake("tests/probe_hall.glb", *HALL)
    far = s.bake("tests/probe_hall.glb", *HALL, settings="[scene]\nprobes = [[0, 40, 0]]\n")
    s.render("one probe far above: balls lit alike, no occlusion", far)
    s.render("probes every 0.6 m: light and occlusion by place", baked)
    s.render("view probes: light", baked, "--view", "probes")
    s.render("view shadowmask: red is occlusion on the balls", baked, "--view", "shadowmask")
    s.render("only baked: shadow distance 0.5 m", baked, "--shadow-distance", "0.5")
    s.render("path traced, for comparison", baked, "--reference", "64")


def instances(s):
    """S15: 1023 balls, one node, one draw, each with its own probe light and occlusion."""
    baked = s.bake("tests/instances_1023.glb", *HALL)
    s.columns = 2
    s.render("1023 instances, each with its own probes", baked, size="720x405")
    s.render("path traced, for comparison", baked, "--reference", "64", size="720x405")
    s.render("view probes", baked, "--view", "probes", size="720x405")
    s.render("view shadowmask: occlusion by instance", baked, "--view", "shadowmask", size="720x405")


def proxy_volumes(s):
    """S16, S17: a beam from one wall's light to the other's, and a group of instances, by one sample or by a volume."""
    baked = s.bake("tests/probe_hall.glb", *HALL)
    coarse = s.bake("tests/probe_hall.glb", *HALL, settings='[[node]]\npattern = "beam"\nprobes = "volume"\nprobe_resolution = 2\n')
    group = s.bake("tests/instances_1023.glb", *HALL, settings='[[node]]\npattern = "balls"\nprobes = "volume"\n')
    close = ("--eye", "0.3,2.1,2.6", "--target", "0.0,1.2,-2.2", "--fov", "62")
    s.render("beam by one sample at its middle", baked, *close, "--proxy-volumes", "off")
    s.render("beam in a proxy volume: light and occlusion along it", baked, *close)
    s.render("path traced, for comparison", baked, "--reference", "64", *close)
    s.render("view probes, one sample", baked, *close, "--view", "probes", "--proxy-volumes", "off")
    s.render("view probes, volume", baked, *close, "--view", "probes")
    s.render("view probes, volume of 2 x 2 x 2 texels", coarse, *close, "--view", "probes")
    s.render("view shadowmask, one sample: occlusion", baked, *close, "--view", "shadowmask", "--proxy-volumes", "off")
    s.render("view shadowmask, volume", baked, *close, "--view", "shadowmask")
    s.render("1023 instances in one volume", group)


def subtractive(s):
    """S21 to S25: dynamic shadows taken out of a lightmap. Left sphere static, right one dynamic."""
    options = ("tests/sphere_on_floor.glb", "--mode", "subtractive", "--quality", "medium", "--lightmap-size", "1024")
    plain = s.bake(*options)
    tinted = s.bake(*options, settings="[scene]\nshadow_color = [2.0, 2.2, 3.0]\n")
    s.render("subtractive, shadow colour black", plain)
    s.render("shadow colour 2.0, 2.2, 3.0 lux", tinted)
    s.render("the same, strength 0.5 after the colour", tinted, "--light", "sun:strength=0.5")
    s.render("shadow distance 6.5 m, range 2 m: fading", tinted, "--shadow-distance", "6.5", "--shadow-fade-range", "2")
    s.render("no realtime shadow: the lightmap as it is", tinted, "--shadow-distance", "0.5")
    s.render("path traced, for comparison", plain, "--reference", "64")


def switches(s):
    """S30: who throws and who receives shadows. Left sphere static and baked, right one dynamic."""
    options = ("tests/sphere_on_floor.glb", "--mode", "shadowmask", "--quality", "medium", "--lightmap-size", "1024")
    sphere = '[[node]]\npattern = "sphere_{}"\ncast_shadows = false\n'
    s.render("all switches on", s.bake(*options))
    s.render("static sphere throws none: its mask is lit", s.bake(*options, settings=sphere.format("static")))
    s.render("dynamic sphere throws none", s.bake(*options, settings=sphere.format("dynamic")))
    s.render("the floor's node receives none", s.bake(*options, settings='[[node]]\npattern = "floor"\nreceive_shadows = false\n'))
    s.render("the spheres' material throws none", s.bake(*options, settings='[[material]]\npattern = "red"\ncast_shadows = false\n'))
    s.render("the floor's material receives none", s.bake(*options, settings='[[material]]\npattern = "white"\nreceive_shadows = false\n'))


def forward_deferred(s):
    """S26, S27: the same picture on both paths."""
    for mode in ("shadowmask", "subtractive"):
        baked = s.bake("courtyard.glb", "--mode", mode, "--quality", "preview")
        options = ("--mode", mode, "--camera", "showcase", "--shadow-distance", "12", "--shadow-fade-range", "3")
        forward = s.render(f"forward, {mode}", baked, *options, "--path", "forward")
        deferred = s.render(f"deferred, {mode}", baked, *options, "--path", "deferred")
        s.difference("difference × 32", forward, deferred, 32)


def cascades(s):
    """S2: number of cascades."""
    baked = s.bake(*AVENUE)
    s.columns = 4
    view = ("--mode", "baked-indirect", "--camera", "high", "--shadow-distance", "50")
    for count in (1, 2, 3, 4):
        s.render(f"view cascades: {count}", baked, *view, "--cascades", count, "--view", "cascades")
    close = ("--mode", "baked-indirect", "--camera", "close")
    s.render("1 cascade: coarse near", baked, *close, "--cascades", "1")
    for kind in ("hard", "pcf", "soft"):
        s.render(f"filter {kind}, 4 cascades", baked, *close, "--shadow-filter", kind)


def overflow(s):
    """S10: five mixed points overlap; the fifth, magenta, is fully baked."""
    baked = s.bake("tests/five_lights.glb", "--quality", "medium", "--lightmap-size", "1024", "--mask-layers", "1")
    s.render("five overlapping lights: four masks, one baked", baked)
    s.render("path traced, for comparison", baked, "--reference", "64")
    s.render("view shadowmask: four channels", baked, "--view", "shadowmask")
    s.render("view overlap: red is four lights with a mask", baked, "--view", "overlap")
    off = [part for i in range(1, 5) for part in ("--light", f"point_{i}:intensity=0")]
    s.render("the four switched off: what is baked", baked, *off)
    s.render("view lightmap: it holds the fifth's direct light", baked, "--view", "lightmap")


def thirteen_lights(s):
    """S36: thirteen mixed lamps that reach everything, in four mask layers."""
    scene = ("tests/thirteen_lights.glb", "--quality", "medium", "--lightmap-size", "1024")
    baked = s.bake(*scene)
    baked_shadows = ("--shadow-distance", "0.5", "--shadow-fade-range", "0.4")
    s.render("thirteen lamps, each with a mask: baked shadows", baked, *baked_shadows)
    s.render("the same with realtime shadows of dynamic objects", baked)
    s.render("path traced", baked, "--reference", "64")
    one = s.bake(*scene, "--mask-layers", "1")
    three = [part for i in range(1, 14) for part in ("--light", f"lamp_{i}:intensity={8 if i in (2, 7, 12) else 0}")]
    s.render("lamps 2, 7 and 12 at 8 cd, all others off, deferred", baked, *baked_shadows, *three, "--path", "deferred")
    s.render("in one layer they are baked, and do not change", one, *baked_shadows, *three)
    s.render("view shadowmask: all layers together", baked, "--view", "shadowmask")


def coloured_glass(s):
    """S35: a room with three coloured windows under a baked and a mixed sun."""
    scene = ("tests/coloured_glass.glb", "--quality", "medium", "--lightmap-size", "1024")
    baked = s.bake(*scene)
    s.render("sun and sky through a film, a pane and a block: baked", baked)
    s.render("path traced", baked, "--reference", "192")
    grey = s.bake(*scene, settings='[[material]]\npattern = "film"\ntinted = false\n')
    s.render("the film is not tinted: alpha is coverage", grey)
    mixed = s.bake(*scene, settings='[[light]]\npattern = "sun"\nmode = "mixed"\n')
    s.render("a mixed sun: its mask has the colours", mixed, "--mode", "shadowmask")
    s.render("deferred, beyond the shadow distance", mixed, "--mode", "distance-shadowmask", "--shadow-distance", "0.5", "--shadow-fade-range", "0.4",
             "--path", "deferred")
    s.render("view shadowmask: red, green and blue of the sun", mixed, "--view", "shadowmask")


def light_groups(s):
    """S33: one bake of five light groups in four states, the last path traced too."""
    baked = s.bake("tests/light_groups.glb", "--quality", "medium", "--lightmap-size", "512")
    s.render("one bake: sun, sky, neon strips, red lamp", baked)
    s.render("no sun, a dim sky", baked, "--group", "sun=0", "--group", "day=0.02")
    off = [part for name in ("sun", "day", "west", "east") for part in ("--group", f"{name}=0")]
    s.render("the lamp alone, at four times its light", baked, *off, "--group", "lamp=4,0.4,0.2")
    s.render("the lamp alone, white", baked, *off, "--group", "lamp=4")
    s.render("the same path traced", baked, *off, "--group", "lamp=4", "--reference", "192")


def directional_lightmap(s):
    """S32: a normal map under baked light alone, a warm panel on the left and a blue lamp on the right."""
    baked = s.bake("tests/bumpy_wall.glb", "--quality", "high", "--lightmap-size", "1024", "--directional", "on")
    s.render("directional lightmap: bumps by baked light", baked)
    s.render("without directions: flat", baked, "--directional", "off")
    s.render("path traced", baked, "--reference", "64")


def debug_views(s):
    """S31: every view of one picture."""
    baked = s.bake("courtyard.glb", "--mode", "shadowmask", "--quality", "preview")
    s.columns = 4
    options = ("--camera", "showcase", "--shadow-distance", "12", "--shadow-fade-range", "3")
    s.render("lit", baked, *options)
    s.render("shadowmask: R, G, B channels 0-2, A darker", baked, *options, "--view", "shadowmask")
    s.render("lightmap (dynamic objects black)", baked, *options, "--view", "lightmap")
    s.render("probes", baked, *options, "--view", "probes")
    s.render("cascades: red, green, blue, yellow, then white", baked, *options, "--view", "cascades")
    s.render("fade: black near … white beyond", baked, *options, "--view", "fade")
    s.render("overlap: 1 blue, 2 green, 3 yellow, 4 red", baked, *options, "--view", "overlap")
    s.render("realtime mode: nothing baked", baked, *options, "--mode", "realtime")


SHEETS = (shadow_fade, cascades, shadowmask, distance_shadowmask, four_lights, point_masks, probes, proxy_volumes, instances, subtractive,
          switches, forward_deferred, overflow, thirteen_lights, coloured_glass, light_groups, directional_lightmap, debug_views)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--halflight", type=pathlib.Path, default=ROOT / "build/release/apps/halflight/halflight")
    parser.add_argument("--only", help="names of sheets, separated by commas")
    parser.add_argument("--fresh", action="store_true", help="bake anew")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    names = {make.__name__: make for make in SHEETS}
    if arguments.list:
        print("\n".join(f"{name:20} {make.__doc__}" for name, make in names.items()))
        return
    wanted = arguments.only.split(",") if arguments.only else list(names)
    for name in wanted:
        if name not in names:
            sys.exit(f"make_contact_sheets.py: no sheet is called {name}; --list names them")
    if not arguments.halflight.is_file():
        sys.exit(f"make_contact_sheets.py: {arguments.halflight} is not built")
    IMAGES.mkdir(parents=True, exist_ok=True)
    for name in wanted:
        sheet = Sheet(name, arguments.halflight.resolve(), arguments.fresh)
        names[name](sheet)
        sheet.write()


if __name__ == "__main__":
    main()
