"""Procedural tiling pictures as PNG bytes: noise, plaster, stone, tiles, wood, leaves, and normal maps from heights."""

import math
import random
import struct
import zlib


def png(width, height, channels, rows):
    """rows: one bytes-like per line. Each whole picture takes the line filter (none, left, up) that packs smallest."""
    def packed(kind):
        lines, above = [], bytes(width * channels)
        for row in rows:
            if kind == 1:
                line = bytes((x - y) & 255 for x, y in zip(row, bytes(channels) + bytes(row)))
            elif kind == 2:
                line = bytes((x - y) & 255 for x, y in zip(row, above))
                above = row
            else:
                line = bytes(row)
            lines.append(bytes([kind]) + line)
        return zlib.compress(b"".join(lines), 9)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", min((packed(k) for k in (0, 1, 2)), key=len)) +
            chunk(b"IEND", b""))


def noise(size, cells, octaves, seed, stretch=1):
    """Tiling value noise in 0…1 (rows of floats): `cells` per side in the first octave, `stretch` times fewer down."""
    rng = random.Random(seed)
    total = [[0.0] * size for _ in range(size)]
    weight, norm = 1.0, 0.0
    for octave in range(octaves):
        nx, ny = cells << octave, max(1, (cells << octave) // stretch)
        if nx > size:
            break
        lattice = [[rng.random() for _ in range(nx)] for _ in range(ny)]
        columns = []
        for x in range(size):
            f = x * nx / size
            i = int(f)
            t = f - i
            columns.append((i, (i + 1) % nx, t * t * (3 - 2 * t)))
        for y in range(size):
            f = y * ny / size
            j = int(f)
            t = f - j
            t = t * t * (3 - 2 * t)
            a, b, out = lattice[j], lattice[(j + 1) % ny], total[y]
            line = [p + (q - p) * t for p, q in zip(a, b)]
            for x, (i, k, s) in enumerate(columns):
                out[x] += weight * (line[i] + (line[k] - line[i]) * s)
        norm += weight
        weight *= 0.5
    return [[v / norm for v in row] for row in total]


def colored(size, function, step=2):
    """RGB picture of function(x, y) → sRGB 0…255; values are rounded to `step`, which packs better and is not seen."""
    rows = []
    for y in range(size):
        row = bytearray()
        for x in range(size):
            row += bytes(max(0, min(255, int(v / step + 0.5) * step)) for v in function(x, y))
        rows.append(row)
    return png(size, size, 3, rows)


def normal_map(height, strength, step=2):
    """Tiling height field (rows of floats, in texels) to a glTF normal map (+Y up)."""
    size = len(height)
    rows = []
    for y in range(size):
        above, line, below = height[y - 1], height[y], height[(y + 1) % size]
        row = bytearray()
        for x in range(size):
            dx = (line[(x + 1) % size] - line[x - 1]) * 0.5 * strength
            dy = (above[x] - below[x]) * 0.5 * strength
            n = 127.0 / math.sqrt(dx * dx + dy * dy + 1.0)
            row += bytes((128 + int(round(-dx * n / step)) * step, 128 + int(round(-dy * n / step)) * step,
                          128 + int(round(n / step)) * step if n < 126 else 255))
        rows.append(row)
    return png(size, size, 3, rows)


def mix(a, b, t):
    return [x + (y - x) * t for x, y in zip(a, b)]


def plaster(size=512):
    """Lime wash: broad clouds of two tones, faint grain."""
    clouds, grain = noise(size, 3, 5, 11), noise(size, 64, 3, 12)
    light, dark = (238, 218, 184), (219, 190, 147)

    def tone(x, y):
        t = max(0.0, min(1.0, (clouds[y][x] - 0.3) * 2.5))
        return [v + (grain[y][x] - 0.5) * 14 for v in mix(dark, light, t)]

    return colored(size, tone, 4)


def limestone(size=256):
    """Pale stone: clouds, a few darker pits."""
    clouds, pits = noise(size, 4, 5, 21), noise(size, 32, 2, 22)

    def tone(x, y):
        base = mix((201, 189, 166), (231, 222, 204), clouds[y][x] * 1.6 - 0.3)
        return [v - 26 * max(0.0, pits[y][x] - 0.72) / 0.28 for v in base]

    return colored(size, tone, 3)


def paving(size=512, tiles=4):
    """Square slabs, each of its own tone, with joints; colour and normal map."""
    rng = random.Random(31)
    shade = [[rng.random() for _ in range(tiles)] for _ in range(tiles)]
    tilt = [[(rng.uniform(-1, 1), rng.uniform(-1, 1)) for _ in range(tiles)] for _ in range(tiles)]
    clouds, grain = noise(size, 8, 4, 32), noise(size, 64, 2, 33)
    cell = size // tiles
    height, wear = [], []
    for y in range(size):
        row, worn = [], []
        for x in range(size):
            i, j, u, v = x // cell, y // cell, x % cell + 0.5, y % cell + 0.5
            edge = min(u, v, cell - u, cell - v) + (clouds[y][x] - 0.5) * 2.5
            slope = tilt[j][i]
            rise = max(0.0, min(1.0, (edge - 1.2) / 3.5))
            rise = rise * rise * (3 - 2 * rise)
            worn.append(rise)
            row.append(3.2 * rise + (clouds[y][x] - 0.5) * 5.0 + (slope[0] * (u - cell / 2) + slope[1] * (v - cell / 2)) * 0.012 * rise)
        height.append(row)
        wear.append(worn)

    def tone(x, y):
        s = shade[y // cell][x // cell]
        base = mix((183, 150, 116), (217, 191, 156), s)
        base = mix(base, (190, 172, 150), 0.35 * clouds[y][x])
        base = [v + (grain[y][x] - 0.5) * 16 + (clouds[y][x] - 0.5) * 22 for v in base]
        return mix((118, 100, 82), base, wear[y][x])

    return colored(size, tone, 4), normal_map(height, 0.8, 4)


def checker(size=256):
    """Two by two glazed tiles, terracotta and cream."""
    clouds = noise(size, 8, 4, 41)
    cell = size // 2

    def tone(x, y):
        dark = (x // cell + y // cell) % 2
        u, v = x % cell + 0.5, y % cell + 0.5
        base = mix((168, 92, 62), (190, 112, 78), clouds[y][x]) if dark else mix((222, 206, 176), (234, 222, 198), clouds[y][x])
        joint = min(1.0, min(u, v, cell - u, cell - v) / 2.0)
        return mix((132, 116, 98), base, joint)

    return colored(size, tone, 3)


def terracotta(size=128):
    clouds, grain = noise(size, 4, 4, 51), noise(size, 32, 2, 52)

    def tone(x, y):
        return [v + (grain[y][x] - 0.5) * 18 for v in mix((165, 84, 55), (205, 121, 82), clouds[y][x])]

    return colored(size, tone, 3)


def wood(dark=(98, 62, 36), light=(139, 92, 55), seed=61, size=256, planks=4):
    """Boards along the picture's height."""
    grain, clouds = noise(size, 64, 2, seed, stretch=16), noise(size, 8, 3, seed + 1, stretch=4)
    rng = random.Random(seed + 2)
    shade = [rng.random() for _ in range(planks)]
    cell = size // planks

    def tone(x, y):
        base = mix(dark, light, 0.55 * shade[x // cell] + 0.45 * clouds[y][x])
        base = [v + (grain[y][x] - 0.5) * 38 for v in base]
        u = x % cell + 0.5
        return mix([0.43 * c for c in dark], base, min(1.0, min(u, cell - u) / 1.6))

    return colored(size, tone, 3)


def foliage(size, seed, leaf, tip, leaves, leaf_length, leaf_width, stem=(84, 66, 40)):
    """A spray of leaves on a stem, alpha 0 or 255 but for a soft rim; colour runs on under the clear parts."""
    rng = random.Random(seed)
    blades = []
    for i in range(leaves):
        t = (i + 0.6) / leaves
        side = 1 if i % 2 else -1
        x, y = 0.5 + 0.05 * math.sin(5 * t), 0.97 - 0.72 * t
        angle = math.pi / 2 - side * (0.95 - 0.55 * t + rng.uniform(-0.2, 0.2))
        scale = (1.0 - 0.35 * abs(t - 0.45)) * rng.uniform(0.88, 1.1)
        blades.append((x, y, math.cos(angle), -math.sin(angle), leaf_length * scale, leaf_width * scale, rng.random()))
    rows = []
    for py in range(size):
        row = bytearray()
        for px in range(size):
            u, v = (px + 0.5) / size, (py + 0.5) / size
            best, color = -1.0, leaf
            for x, y, cx, cy, long, wide, s in blades:
                along = ((u - x) * cx + (v - y) * cy) / long
                if not -0.02 < along < 1.02:
                    continue
                across = abs((v - y) * cx - (u - x) * cy) / wide
                along = max(0.0, min(1.0, along))
                half = math.sqrt(along) * (1.0 - along) * 2.6  # a leaf's outline: blunt below, pointed above
                inside = half - across
                if inside > best:
                    best = inside
                    vein = 1.0 if across > 0.09 else 0.82
                    color = [c * vein for c in mix(leaf, tip, 0.25 * s + 0.75 * along * s + 0.1 * along)]
            trunk = abs(u - (0.5 + 0.05 * math.sin(5 * (0.97 - v) / 0.72)))
            if v > 0.25 and trunk < 0.012 and best < 0.05:
                best, color = 0.3, stem
            alpha = max(0.0, min(1.0, best * 9.0 + 0.5))
            row += bytes(max(0, min(255, int(c / 4 + 0.5) * 4)) for c in color) + bytes([int(alpha * 15 + 0.5) * 17])
        rows.append(row)
    return png(size, size, 4, rows)
