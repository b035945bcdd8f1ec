# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of the bake's probes at a place: docs/format.md, "Probes" and "Sight". Imports nothing of Blender."""

import math

import numpy as np

EXTENSION = "HALFLIGHT_mixed_lighting"
LEAST_SIGHT, LEAST_DEVIATION = 0.002, 0.005  # of include/halflight/shading/sight.h
LOBE = np.array([math.pi] + 3 * [2.0 * math.pi / 3.0] + 5 * [math.pi / 4.0])
FACTORS = np.array([0.282094792, *3 * [0.488602512], *2 * [1.092548431], 0.315391565, 1.092548431, 0.546274215])


def polynomials(directions):
    """Rows 1, y, z, x, xy, yz, 3z² − 1, xz, x² − y²: the basis without its factors."""
    x, y, z = np.asarray(directions, np.float64).T
    return np.stack([np.ones_like(x), y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y], 1)


def sphere(count):
    """Directions of about equal solid angles (Fibonacci's spiral)."""
    height = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    angle = np.arange(count) * math.pi * (3.0 - math.sqrt(5.0))
    radius = np.sqrt(1.0 - height * height)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], 1)


CHECKED = polynomials(sphere(256))


class Probes:
    """sample() has the irradiance on any normal, as factors of polynomials(), and the occlusion of each channel."""

    def __init__(self, document):
        """`document`: the baked file."""
        root = document.json.get("extensions", {}).get(EXTENSION, {})
        record = root.get("probes", {})
        self.root, self.weights = root, None
        self.sky = radiance_of_sky(root.get("sky", {}))
        self.count = record.get("count", 0) if "positions" in record else 0
        if self.count == 0:
            return
        self.positions = document.accessor(record["positions"]).astype(np.float64) + root.get("origin", (0.0, 0.0, 0.0))
        self.rest = self.radiance = self.radiance_in(document, record)
        self.groups = {group["name"]: self.radiance_in(document, group) for group in root.get("groups", []) if "radiance" in group}
        self.occlusion = document.accessor(record["occlusion"]).astype(np.float64)
        valid = document.accessor(record["valid"]).reshape(-1) if "valid" in record else np.ones(self.count)
        self.valid = np.flatnonzero(valid)
        self.corners = np.zeros((0, 4), np.int64)
        if "tetrahedra" in record:
            self.corners = document.accessor(record["tetrahedra"]).astype(np.int64)
            places = self.positions[self.corners]
            # Barycentric shares of the last three corners: inverse @ (place - first corner).
            a, b, c = (places[:, i] - places[:, 0] for i in (1, 2, 3))
            rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], 1)
            volume = np.einsum("ni,ni->n", a, rows[:, 0])
            self.inverse = rows / np.maximum(volume, 1e-30)[:, None, None]
        self.read_sight(document, record)

    def radiance_in(self, document, record):
        return document.accessor(record["radiance"]).reshape(self.count, 9, 3).astype(np.float64)

    def compose(self, weights):
        """Adds up the light of groups. `weights`: by name of a group."""
        if weights == self.weights:
            return
        self.weights = weights
        if self.count > 0:
            shares = [np.asarray(weights[name]) * light for name, light in self.groups.items() if name in weights]
            self.radiance = self.rest + sum(shares)
        self.sky = radiance_of_sky(sky_at(self.root, weights))

    def read_sight(self, document, record):
        self.ranges = np.zeros(self.count)
        if "sight" not in record:
            return
        self.ranges = document.accessor(record["sightRanges"]).reshape(-1).astype(np.float64)
        corners = document.accessor(record["sight"]).astype(np.float64)
        with_map = self.ranges > 0.0
        self.size = round(math.sqrt(len(corners) / max(int(with_map.sum()), 1)))
        nearness = 65535.0 / np.maximum(corners[:, 0], 1.0)
        moments = np.stack([nearness, (nearness * corners[:, 1] / 65535.0) ** 2], 1)
        self.moments = moments.reshape(-1, self.size, self.size, 2)
        self.map_of = np.cumsum(with_map) - 1

    def sample(self, place):
        if self.count == 0 or len(self.valid) == 0:
            return irradiance_of(self.sky), np.ones(4)
        probes, shares = self.shares(np.asarray(place, np.float64))
        shares = shares * [self.sight(probe, place) for probe in probes]
        shares = shares / shares.sum()
        radiance = np.tensordot(shares, self.radiance[probes], 1)
        return irradiance_of(radiance), np.clip(shares @ self.occlusion[probes], 0.0, 1.0)

    def shares(self, place):
        """Probes and their barycentric shares; outside the hull, those of the nearest place in a tetrahedron's corners."""
        if len(self.corners) == 0:
            distance = ((self.positions[self.valid] - place) ** 2).sum(1)
            return self.valid[[distance.argmin()]], np.ones(1)
        first = self.positions[self.corners[:, 0]]
        rest = np.einsum("nij,nj->ni", self.inverse, place - first)
        shares = np.concatenate([1.0 - rest.sum(1, keepdims=True), rest], 1)
        index = shares.min(1).argmax()
        if shares[index].min() < -1e-6:
            clamped = np.clip(shares, 0.0, None)
            clamped /= clamped.sum(1, keepdims=True)
            nearest = np.einsum("nk,nkj->nj", clamped, self.positions[self.corners])
            index = ((nearest - place) ** 2).sum(1).argmin()
            return self.corners[index], clamped[index]
        return self.corners[index], np.clip(shares[index], 0.0, None)

    def sight(self, probe, place):
        """Weight of a probe for a place: that of one that sees nothing of it is LEAST_SIGHT."""
        reach = self.ranges[probe]
        offset = place - self.positions[probe]
        meters = np.abs(offset).sum()
        if reach <= 0.0 or meters <= 0.0:
            return 1.0
        x, y, z = offset / meters
        if z < 0.0:
            x, y = (1.0 if x >= 0.0 else -1.0) * (1.0 - abs(y)), (1.0 if y >= 0.0 else -1.0) * (1.0 - abs(x))
        cells = self.size - 1
        at = (np.array([x, y]) * 0.5 + 0.5) * cells
        cell = np.clip(at.astype(int), 0, cells - 1)
        u, v = at - cell
        mirrored = (2 * cell[0] < cells) != (2 * cell[1] < cells)
        nearness = variance = 0.0
        for row in (0, 1):
            for column in (0, 1):
                share = corner_share(column, row, u, v, mirrored)
                moments = self.moments[self.map_of[probe], cell[1] + row, cell[0] + column]
                nearness, variance = nearness + share * moments[0], variance + share * moments[1]
        spread = max(variance, (LEAST_DEVIATION * nearness) ** 2)
        excess = max(nearness - max(reach / meters, 1.0), 0.0)
        return max((spread / (spread + excess * excess)) ** 3, LEAST_SIGHT)


def corner_share(column, row, u, v, mirrored):
    """octahedralShare() of include/halflight/shading/sight.h."""
    across = 1.0 - u if mirrored else u
    side = 1 - column if mirrored else column
    if side == row:
        return max(1.0 - across - v if row == 0 else across + v - 1.0, 0.0)
    return min(across, 1.0 - v) if row == 0 else min(v, 1.0 - across)


def irradiance_of(radiance):
    """Factors of polynomials(), nine rows of RGB. Bands 1 and 2 are as weak as irradiance needs that is nowhere negative."""
    factors = radiance * (LOBE * FACTORS)[:, None]
    varying = CHECKED[:, 1:] @ factors[1:]
    least = -varying.min(0)
    share = np.where(least > factors[0], np.maximum(factors[0], 0.0) / np.maximum(least, 1e-30), 1.0)
    factors[1:] *= share
    return factors


def sky_at(root, weights):
    """The sky's gradient at these weights: docs/format.md, "Light groups"."""
    sky = {key: root.get("sky", {}).get(key, (0.0, 0.0, 0.0)) for key in ("horizon", "zenith", "ground")}
    white = max(max(color) for color in sky.values()) or 1.0
    for group in root.get("groups", []):
        weight, part = weights.get(group["name"]), group["name"].removeprefix("sky.")
        if not group.get("sky") or weight is None:
            continue
        for key, color in sky.items():
            if part == key:
                sky[key] = weight
            elif part not in sky:
                pairs = zip(color, weight, group["weight"])
                sky[key] = [c * w / saved if saved > 0.0 else w * white for c, w, saved in pairs]
    return sky


def radiance_of_sky(sky):
    """Coefficients of the sky's gradient, which is the nearest one where the sky is a picture."""
    directions = sphere(4096)
    up = directions[:, 1:2]
    horizon, zenith, ground = (np.asarray(sky.get(key, (0.0, 0.0, 0.0))) for key in ("horizon", "zenith", "ground"))
    light = horizon + (zenith - horizon) * np.maximum(up, 0.0) + (ground - horizon) * np.maximum(-up, 0.0)
    return (polynomials(directions) * FACTORS).T @ light * (4.0 * math.pi / len(directions))
