"""Stained glass, painted: pieces of coloured glass between dark leads, as PNG bytes."""

import math
import random

from . import texture

RUBY, SAPPHIRE, EMERALD, AMBER, PALE, VIOLET = (
    (214, 22, 26), (26, 58, 226), (28, 168, 74), (250, 176, 34), (236, 226, 178), (140, 44, 190))
LEAD = (12, 11, 12)
STEP = 6  # rounding of tones, which packs better


def _picture(width, height, piece):
    """`piece(x, y)`, of pixels: a key of the piece of glass there, its colour, and the distance to its lead in pixels."""
    rows, tones = [], {}
    for y in range(height):
        row = bytearray()
        for x in range(width):
            key, color, edge = piece(x + 0.5, y + 0.5)
            if key not in tones:
                tones[key] = random.Random(str(key)).uniform(0.72, 1.06)
            glass = [c * tones[key] for c in color]
            row += bytes(max(0, min(255, int(c / STEP + 0.5) * STEP)) for c in texture.mix(LEAD, glass, max(0.0, min(1.0, edge - 0.6))))
        rows.append(row)
    return texture.png(width, height, 3, rows)


def lancet(seed=1, width=128, height=256):
    """Quarries of pale glass, a border of red and blue, and three medallions."""
    order = [RUBY, SAPPHIRE, EMERALD, AMBER, VIOLET]
    random.Random(seed).shuffle(order)
    border, cell = width * 0.13, width * 0.17
    middles = [height * share for share in (0.3, 0.56, 0.82)]

    def piece(x, y):
        side = min(x, width - x, height - y)
        if side < border:
            along = y if side < height - y else x
            i = int(along / (1.6 * border))
            edge = min(side, border - side, along % (1.6 * border), 1.6 * border - along % (1.6 * border))
            return ("border", i, x < width / 2, side == height - y), (order[0] if i % 2 else order[1]), edge + 0.3
        for n, middle in enumerate(middles):
            dx, dy = x - width / 2, y - middle
            r = math.hypot(dx, dy)
            outer, inner = width * 0.31, width * 0.14
            if r < inner:
                return ("heart", n), order[3 if n != 1 else 2], inner - r
            if r < outer:
                turn = (math.atan2(dy, dx) / math.tau + 0.0625) % 1.0 * 8
                across = min(turn % 1.0, 1.0 - turn % 1.0) * math.tau * r / 8
                return ("petal", n, int(turn)), order[(int(turn) + n) % 2 * 4 if int(turn) % 2 else 1 - n % 2], min(outer - r, r - inner, across)
        u, v = (x + 0.7 * y) / cell, (x - 0.7 * y) / cell
        edge = min(u % 1.0, 1 - u % 1.0, v % 1.0, 1 - v % 1.0) * cell * 0.75
        near = min(math.hypot(x - width / 2, y - middle) - width * 0.31 for middle in middles)
        return ("quarry", int(u), math.floor(v)), (AMBER if (int(u) + math.floor(v)) % 5 == 0 else PALE), min(edge, near, side - border)

    return _picture(width, height, piece)


def rose(size=256, petals=12):
    """Rings of petals around a heart, as the tracery of rose_tracery() divides them."""
    rings = ((0.0, 0.17, 1, (AMBER,)), (0.17, 0.5, petals, (SAPPHIRE, RUBY)), (0.5, 0.78, petals * 2, (RUBY, SAPPHIRE, VIOLET, SAPPHIRE)),
             (0.78, 1.01, petals * 2, (EMERALD, AMBER)))

    def piece(x, y):
        dx, dy = x - size / 2, y - size / 2
        r = math.hypot(dx, dy) / (size / 2)
        for n, (inner, outer, count, colors) in enumerate(rings):
            if r >= outer:
                continue
            turn = (math.atan2(dy, dx) / math.tau % 1.0) * count
            if count > 1 and n != 1:
                turn = (turn + 0.5) % count
            across = min(turn % 1.0, 1.0 - turn % 1.0) * math.tau * r / count if count > 1 else 1.0
            bow = 0.5 * abs(math.sin(math.pi * turn * 2)) * 0.06 if n == 1 else 0.0
            edge = min(outer - r - bow, (r - inner) if inner else 1.0, across) * size / 2
            return (n, int(turn), bow > 0.02), colors[int(turn) % len(colors)], edge
        return ("out",), LEAD, 9.0

    return _picture(size, size, piece)
