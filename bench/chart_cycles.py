#!/usr/bin/env python3
"""Draws the figures of compare_cycles.py: error by the processor's seconds, and the ratio at equal error.

    bench/chart_cycles.py [FIGURES.json] [-o CHART.svg]
"""

import argparse
import json
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent

WIDTH, HEIGHT = 860, 380
PANEL_WIDTH, PANEL_HEIGHT = 350, 250
TOP, LEFT, SPACING = 46, 62, 420
SECONDS, ERRORS = (1, 2, 5, 10, 20, 50, 100, 200, 500), (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
TITLES = {"cornell": "Cornell box, one lamp", "courtyard": "Courtyard, sun"}

# The page's own colours follow the reader's; a card of its own keeps it readable where they are not known.
STYLE = """
  .card { fill: #ffffff; stroke: #d0d4da }
  text { fill: #24292f; font: 13px system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif }
  .title { font-size: 16px; font-weight: 600 }
  .small { fill: #57606a; font-size: 12px }
  .grid { stroke: #e3e6ea }
  .line { fill: none; stroke-width: 2.5; stroke-linejoin: round }
  .cycles { stroke: #b35900 } .cycles-fill { fill: #b35900 }
  .halflight { stroke: #0860ca } .halflight-fill { fill: #0860ca }
  .name { font-weight: 600 }
  .span { stroke: #24292f; stroke-width: 1.5; stroke-dasharray: 4 3 }
  .ratio { font-size: 16px; font-weight: 600; paint-order: stroke; stroke: #ffffff; stroke-width: 9 }
  @media (prefers-color-scheme: dark) {
    .card { fill: #161b22; stroke: #3d444d }
    text { fill: #e6edf3 } .small { fill: #9da7b1 } .grid { stroke: #2b323b }
    .cycles { stroke: #f0883e } .cycles-fill { fill: #f0883e }
    .halflight { stroke: #58a6ff } .halflight-fill { fill: #58a6ff }
    .span { stroke: #e6edf3 } .ratio { stroke: #161b22 }
  }
"""


class Axis:
    """A logarithmic axis from the tick at or below all values to the one at or above them."""

    def __init__(self, ticks, values, start, end):
        first = max(tick for tick in ticks if tick <= min(values))
        last = min(tick for tick in ticks if tick >= max(values))
        self.ticks = [tick for tick in ticks if first <= tick <= last]
        self.start, self.end = start, end

    def at(self, value):
        share = math.log(value / self.ticks[0]) / math.log(self.ticks[-1] / self.ticks[0])
        return self.start + share * (self.end - self.start)


def text(x, y, words, kind="", anchor="middle"):
    return f'<text x="{x:.1f}" y="{y:.1f}" class="{kind}" text-anchor="{anchor}">{words}</text>'


def line(x1, y1, x2, y2, kind):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" class="{kind}"/>'


def grid(across, up, title):
    """Ticks, their numbers and what they count."""
    left, bottom = across.start, up.start
    parts = [text(left, TOP - 16, title, "title", "start"), text(left - 8, TOP - 16, "error", "small", "end")]
    for tick in across.ticks:
        parts.append(line(across.at(tick), bottom, across.at(tick), up.end, "grid"))
        parts.append(text(across.at(tick), bottom + 18, f"{tick:g}", "small"))
    for tick in up.ticks:
        parts.append(line(left, up.at(tick), across.end, up.at(tick), "grid"))
        parts.append(text(left - 8, up.at(tick) + 4, f"{100 * tick:g} %", "small", "end"))
    parts.append(text((left + across.end) / 2, bottom + 36, "CPU seconds", "small"))
    return parts


def curve(points, across, up, program, name):
    """A program's measured points, joined."""
    places = [(across.at(point["seconds"]), up.at(point["error"])) for point in points]
    joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    parts = [f'<polyline points="{joined}" class="line {program}"/>']
    parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" class="{program}-fill"/>' for x, y in places]
    top = min(places, key=lambda place: place[1])
    parts.append(text(top[0] + 10, top[1] - 6, name, f"name {program}-fill", "start"))
    return parts


def panel(scene, across, up):
    parts = grid(across, up, TITLES.get(scene["name"], scene["name"]))
    equal = scene["equal"]
    height = up.at(equal["error"])
    ours, theirs = across.at(equal["halflight"]), across.at(equal["cycles"])
    parts.append(line(ours, height, theirs, height, "span"))
    for program, name in (("cycles", "Cycles"), ("halflight", "Halflight")):
        parts += curve(scene[program], across, up, program, name)
    parts.append(text((ours + theirs) / 2, height + 6, f"{equal['ratio']:.0f} times", "ratio"))
    parts.append(text(theirs + 6, height + 20, f"{scene['cycles'][-1]['samples']} samples", "small", "end"))
    return parts


def chart(figures):
    """Both panels have the same axes."""
    points = [point for scene in figures["scenes"] for name in ("cycles", "halflight") for point in scene[name]]
    parts = []
    for index, scene in enumerate(figures["scenes"]):
        left = LEFT + index * SPACING
        across = Axis(SECONDS, [point["seconds"] for point in points], left, left + PANEL_WIDTH)
        up = Axis(ERRORS, [point["error"] for point in points], TOP + PANEL_HEIGHT, TOP)
        parts += panel(scene, across, up)
    samples = " and ".join(dict.fromkeys(f"{scene['referenceSamples']:,}" for scene in figures["scenes"]))
    note = f"Error: root mean square of luminance, from {samples} samples of Cycles, whose own noise is taken out."
    parts.append(text(LEFT - 38, HEIGHT - 16, note, "small", "start"))
    label = "Error of a lightmap by CPU seconds: " + "; ".join(
        f"{TITLES.get(scene['name'], scene['name'])}: Cycles takes {scene['equal']['ratio']:.0f} times as long as "
        f"Halflight to an error of {scene['equal']['error']:.1%}"
        for scene in figures["scenes"]
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}"'
    card = f'<rect x="0.5" y="0.5" width="{WIDTH - 1}" height="{HEIGHT - 1}" rx="8" class="card"/>'
    lines = [f'{head} role="img" aria-label="{label}">', f"<style>{STYLE}</style>", card, *parts, "</svg>"]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figures", nargs="?", type=pathlib.Path, default=HERE / "cycles_figures.json")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=HERE.parent / "docs/images/equal_error.svg")
    arguments = parser.parse_args()
    arguments.output.write_text(chart(json.loads(arguments.figures.read_text())))


main()
