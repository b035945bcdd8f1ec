// Prefiltering of reflection probes.

#include "bake/reflections/reflections.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "halflight/shading/brdf.h"
#include "halflight/shading/reflection.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

/// Radiance by direction, with the solid angle of each.
struct Directions {
    std::vector<vec3> direction;
    std::vector<vec3> radiance;
    std::vector<float> steradians;
};

vec3 directionOfTexel(int x, int y, int size)
{
    return shading::directionFromOctahedron((vec2(x, y) + 0.5f) / float(size));
}

/// Solid angle of the triangle between three unit vectors: van Oosterom and Strackee 1983, "The Solid Angle of a Plane
/// Triangle".
float solidAngle(vec3 a, vec3 b, vec3 c)
{
    const float volume = std::abs(glm::dot(a, glm::cross(b, c)));
    return 2.0f * math::atan(volume, 1.0f + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
}

Directions directionsOf(const ImageRgb32f& map)
{
    Directions result;
    const int size = map.width();
    const auto corner = [&](int x, int y) { return shading::directionFromOctahedron(vec2(x, y) / float(size)); };
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            result.direction.push_back(directionOfTexel(x, y, size));
            result.radiance.push_back(map(x, y));
            result.steradians.push_back(solidAngle(corner(x, y), corner(x + 1, y), corner(x + 1, y + 1)) +
                                        solidAngle(corner(x, y), corner(x + 1, y + 1), corner(x, y + 1)));
        }
    }
    return result;
}

/// Half as wide, by means of 2 x 2 texels; the width is even.
ImageRgb32f halved(const ImageRgb32f& map)
{
    ImageRgb32f result(map.width() / 2, map.height() / 2);
    for (int y = 0; y < result.height(); ++y)
        for (int x = 0; x < result.width(); ++x)
            result(x, y) =
                0.25f * (map(2 * x, 2 * y) + map(2 * x + 1, 2 * y) + map(2 * x, 2 * y + 1) + map(2 * x + 1, 2 * y + 1));
    return result;
}

/// Mean of the radiance that a surface reflects along its normal n, weighted by the distribution of its half vectors
/// and by the cosine of the light's direction l: Karis 2013. With the view along n, the half vector's cosine is sqrt((1
/// + n.l) / 2), and the density of l is D / 4.
struct FilteredMean {
    vec3 n;
    float alpha = 1.0f;
    vec3 sum = vec3(0.0f);
    float weights = 0.0f;

    void add(const Directions& light, std::size_t i)
    {
        const float cosine = glm::dot(n, light.direction[i]);
        if (cosine <= 0.0f) return;
        const float nDotH = std::sqrt(0.5f + 0.5f * cosine);
        const float weight = shading::distributionGgx(nDotH, alpha) * cosine * light.steradians[i];
        sum += weight * light.radiance[i];
        weights += weight;
    }
    vec3 mean() const { return weights > 0.0f ? sum / weights : vec3(0.0f); }
};

/// The mean over a map of half the resolution and, within 45 degrees of the lobe's middle, where it is steep, over the
/// four texels of the whole map in the place of one.
vec3 filtered(const Directions& whole, const Directions& half, int halfSize, vec3 n, float alpha)
{
    FilteredMean result{n, alpha};
    for (std::size_t i = 0; i < half.direction.size(); ++i) {
        if (glm::dot(n, half.direction[i]) < glm::one_over_root_two<float>()) {
            result.add(half, i);
            continue;
        }
        const std::size_t x = 2 * (i % std::size_t(halfSize));
        const std::size_t y = 2 * (i / std::size_t(halfSize));
        for (std::size_t k = 0; k < 4; ++k) result.add(whole, (y + k / 2) * std::size_t(2 * halfSize) + x + k % 2);
    }
    return result.mean();
}

/// A level's map within its tile, with the border: one texel beyond an edge lies the texel that is as far from the
/// edge's middle on the other side of it.
void putLevel(const ImageRgb32f& inner, ivec2 offset, ImageRgb32f& tile)
{
    const int size = inner.width();
    const auto value = [&](int x, int y) {
        const bool outsideX = x < 0 || x >= size;
        const bool outsideY = y < 0 || y >= size;
        const int insideX = std::clamp(x, 0, size - 1);
        const int insideY = std::clamp(y, 0, size - 1);
        return inner(outsideY ? size - 1 - insideX : insideX, outsideX ? size - 1 - insideY : insideY);
    };
    for (int y = -1; y <= size; ++y)
        for (int x = -1; x <= size; ++x) tile(offset.x + x + 1, offset.y + y + 1) = value(x, y);
}

} // namespace

ImageRgb32f reflectionTile(const ImageRgb32f& around)
{
    const int size = around.width() + 2;
    ImageRgb32f tile(size, shading::reflectionTileHeight(size));
    putLevel(around, ivec2(0), tile);
    const Directions whole = directionsOf(around);
    const Directions half = directionsOf(halved(around));
    const int halfSize = around.width() / 2;
    for (int level = 1; level < shading::kReflectionLevels; ++level) {
        const float alpha = shading::square(shading::reflectionRoughness(level));
        ImageRgb32f inner(shading::reflectionLevelSize(size, level) - 2, shading::reflectionLevelSize(size, level) - 2);
        parallelFor(std::size_t(inner.height()), 1, [&](std::size_t begin, std::size_t end) {
            for (auto y = int(begin); y < int(end); ++y)
                for (int x = 0; x < inner.width(); ++x)
                    inner(x, y) = filtered(whole, half, halfSize, directionOfTexel(x, y, inner.width()), alpha);
        });
        putLevel(inner, ivec2(shading::reflectionLevelOffset(size, level)), tile);
    }
    return tile;
}

} // namespace halflight
