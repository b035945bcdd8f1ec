// Light probe proxy volumes: probe light resampled on a regular grid about an object.
#include "halflight/base/parallel.h"
#include "halflight/render/probes.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;

/// Thickness given to a box along an axis where it has none, as a share of its largest side; metres where it has no
/// side.
constexpr double kThinnest = 1.0e-3;

dvec3 thicken(dvec3 size)
{
    const double largest = std::max({size.x, size.y, size.z});
    return glm::max(size, dvec3(largest > 0.0 ? kThinnest * largest : kThinnest));
}

/// Takes [0, 1]^3 to a box of this size about the origin of `m`'s space, moved to `center`.
dmat4 unitBox(const dmat4& m, dvec3 center, dvec3 size)
{
    dmat4 result = m;
    for (int axis = 0; axis < 3; ++axis) result[axis] = m[axis] * size[axis];
    result[3] = m * dvec4(center - 0.5 * size, 1.0);
    return result;
}

dmat4 worldFromUnitBox(const Bounds& box, const mat4& worldFromObject)
{
    const dvec3 center = box.empty() ? dvec3(0.0) : 0.5 * (dvec3(box.min) + dvec3(box.max));
    const dvec3 size = box.empty() ? dvec3(0.0) : dvec3(box.max) - dvec3(box.min);
    const dmat4 world = unitBox(dmat4(worldFromObject), center, thicken(size));
    double longest = 0.0;
    for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, glm::length(dvec3(world[axis])));
    if (std::abs(glm::determinant(glm::dmat3(world))) > 1.0e-12 * longest * longest * longest) return world;

    // The transform flattens the object: the box in the world about what is left (Arvo 1990, "Transforming Axis-Aligned
    // Bounding Boxes").
    const dvec3 flattened = glm::abs(dvec3(world[0])) + glm::abs(dvec3(world[1])) + glm::abs(dvec3(world[2]));
    const dvec3 middle(world * dvec4(dvec3(0.5), 1.0));
    return unitBox(dmat4(1.0), middle, thicken(flattened));
}

ivec3 resolutionOf(const dmat4& worldFromUnit, const ProxyVolumeSettings& settings, vec3 spacingMeters)
{
    ivec3 resolution;
    for (int axis = 0; axis < 3; ++axis) {
        if (settings.resolution[axis] > 0) {
            resolution[axis] = std::min(settings.resolution[axis], kMaxProxyResolution);
            continue;
        }
        double crossed = 0.0; // probe spacings along this side of the box
        for (int i = 0; i < 3; ++i) crossed += std::abs(worldFromUnit[axis][i]) / double(spacingMeters[i]);
        resolution[axis] = int(glm::clamp(std::ceil(crossed - 1.0e-4) + 1.0, 2.0, 32.0));
    }
    return resolution;
}

void store(ProxyVolume& volume, std::size_t at, const ProbeSample& sample)
{
    const SphericalHarmonicsL2& r = sample.radiance;
    for (int c = 0; c < 3; ++c) {
        volume.textures[std::size_t(c)][at] = {r[0][c], r[1][c], r[2][c], r[3][c]};
        volume.textures[std::size_t(4 + c)][at] = {r[4][c], r[5][c], r[6][c], r[7][c]};
    }
    volume.textures[3][at] = sample.occlusion;
    volume.textures[7][at] = vec4(r[8], 0.0f);
}

} // namespace

ProxyVolume makeProxyVolume(const ProbeInterpolator& probes, const Bounds& box, const mat4& worldFromObject,
                            const ProxyVolumeSettings& settings)
{
    const dmat4 worldFromUnit = worldFromUnitBox(box, worldFromObject);
    ProxyVolume volume;
    volume.resolution = resolutionOf(worldFromUnit, settings, probes.spacingMeters());
    const dvec3 size(volume.resolution);
    const dvec3 intervals = glm::max(size - 1.0, dvec3(1.0));

    // Box coordinate 0 is at the first texel's centre, 1 at the last one's; a single texel stands for all.
    dmat4 volumeFromUnit(1.0);
    for (int axis = 0; axis < 3; ++axis) {
        if (volume.resolution[axis] < 2) continue;
        volumeFromUnit[axis][axis] = intervals[axis] / size[axis];
        volumeFromUnit[3][axis] = 0.5 / size[axis];
    }
    volume.volumeFromWorld = mat4(volumeFromUnit * glm::inverse(worldFromUnit));

    const ivec3 n = volume.resolution;
    const std::size_t row = std::size_t(n.x);
    const std::size_t rows = std::size_t(n.y) * std::size_t(n.z);
    for (auto& texture : volume.textures) texture.resize(row * rows);
    parallelFor(rows, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t x = 0; x < row; ++x) {
                dvec3 place = dvec3(x, i % std::size_t(n.y), i / std::size_t(n.y)) / intervals;
                for (int axis = 0; axis < 3; ++axis) {
                    if (n[axis] < 2) place[axis] = 0.5;
                }
                store(volume, i * row + x, probes.sample(vec3(worldFromUnit * dvec4(place, 1.0))));
            }
        }
    });
    return volume;
}

ProxyVolume makeProxyVolume(const ProbeInterpolator& probes, const Bounds& worldBox,
                            const ProxyVolumeSettings& settings)
{
    return makeProxyVolume(probes, worldBox, mat4(1.0f), settings);
}

ProbeSample sampleProxyVolume(const ProxyVolume& volume, vec3 worldPosition)
{
    const vec3 last = vec3(volume.resolution - 1);
    const vec3 coordinate = vec3(volume.volumeFromWorld * vec4(worldPosition, 1.0f));
    const vec3 at = glm::clamp(coordinate * vec3(volume.resolution) - 0.5f, vec3(0.0f), last);
    const ivec3 low = glm::min(ivec3(at), glm::max(volume.resolution - 2, ivec3(0)));
    const vec3 part = at - vec3(low);
    std::array<vec4, ProxyVolume::kTextures> sum{};
    for (int corner = 0; corner < 8; ++corner) {
        const ivec3 side(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        float weight = 1.0f;
        for (int axis = 0; axis < 3; ++axis) weight *= side[axis] != 0 ? part[axis] : 1.0f - part[axis];
        if (weight <= 0.0f) continue;
        const ivec3 p = low + side;
        const std::size_t texel = (std::size_t(p.z) * std::size_t(volume.resolution.y) + std::size_t(p.y)) *
                                      std::size_t(volume.resolution.x) +
                                  std::size_t(p.x);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * volume.textures[i][texel];
    }
    ProbeSample sample;
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 4; ++i) {
            sample.radiance[std::size_t(i)][c] = sum[std::size_t(c)][i];
            sample.radiance[std::size_t(4 + i)][c] = sum[std::size_t(4 + c)][i];
        }
    }
    sample.occlusion = sum[3];
    sample.radiance[8] = vec3(sum[7]);
    return sample;
}

} // namespace halflight
