// Light probe proxy volumes: probe light resampled on a regular grid about an object.
#include "halflight/base/parallel.h"
#include "halflight/render/probes.h"
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <cmath>
#include <map>

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

/// World box of a volume's objects.
Bounds worldBoxOf(const Scene& scene, std::span<const Bounds> meshBounds, std::span<const uint32_t> objects)
{
    Bounds box;
    for (const uint32_t i : objects) {
        const Object& object = scene.objects[i];
        box.extend(worldBounds(meshBounds[std::size_t(object.mesh)], object.worldFromObject));
    }
    return box;
}

std::size_t texelCount(ivec3 resolution)
{
    return std::size_t(resolution.x) * std::size_t(resolution.y) * std::size_t(resolution.z);
}

std::size_t occlusionTexture(std::size_t maskLayer)
{
    return maskLayer == 0 ? 3 : 7 + maskLayer;
}

void store(ProxyVolume& volume, std::size_t at, const ProbeSample& sample)
{
    const SphericalHarmonicsL2& r = sample.radiance;
    for (int c = 0; c < 3; ++c) {
        volume.textures[std::size_t(c)][at] = {r[0][c], r[1][c], r[2][c], r[3][c]};
        volume.textures[std::size_t(4 + c)][at] = {r[4][c], r[5][c], r[6][c], r[7][c]};
    }
    for (std::size_t k = 0; k < sample.occlusion.layers.size(); ++k)
        volume.textures[occlusionTexture(k)][at] = sample.occlusion.layers[k];
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

ProxyVolumePlan planProxyVolumes(const Scene& scene, std::span<const Bounds> meshBounds,
                                 const std::vector<bool>& lightmapped, const ProbeInterpolator& probes)
{
    ProxyVolumePlan plan;
    plan.volumeOf.assign(scene.objects.size(), -1);
    if (probes.probeCount() == 0) return plan;
    const vec3 spacing = probes.spacingMeters();
    const auto add = [&](std::vector<uint32_t> objects, bool alongWorldAxes, ivec3 resolution) {
        for (const uint32_t i : objects) plan.volumeOf[i] = int(plan.volumes.size());
        plan.volumes.push_back({std::move(objects), alongWorldAxes, resolution});
    };
    const auto ownResolution = [&](const Object& object, ivec3 wish) {
        const Bounds& box = meshBounds[std::size_t(object.mesh)];
        return resolutionOf(worldFromUnitBox(box, object.worldFromObject), {wish}, spacing);
    };

    std::map<int, std::vector<uint32_t>> groups;
    std::vector<std::pair<uint32_t, ivec3>> automatic;
    for (uint32_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (object.mesh < 0 || lightmapped[i] || meshBounds[std::size_t(object.mesh)].empty()) continue;
        if (object.probeLighting == ProbeLighting::Volume) {
            if (object.probeGroup >= 0)
                groups[object.probeGroup].push_back(i);
            else
                add({i}, false, ownResolution(object, object.probeResolution));
        } else if (object.probeLighting == ProbeLighting::Automatic && object.isStatic) {
            // Longer than probes are apart: more texels than the two ends.
            const ivec3 resolution = ownResolution(object, ivec3(0));
            if (std::max({resolution.x, resolution.y, resolution.z}) > 2)
                automatic.emplace_back(i, ownResolution(object, object.probeResolution));
        }
    }
    for (auto& [group, objects] : groups) {
        const Bounds box = worldBoxOf(scene, meshBounds, objects);
        const ivec3 wish = scene.objects[objects.front()].probeResolution;
        add(std::move(objects), true, resolutionOf(worldFromUnitBox(box, mat4(1.0f)), {wish}, spacing));
    }
    const auto texelsWithin = [&](int most) {
        std::size_t texels = 0;
        for (const auto& volume : plan.volumes) texels += texelCount(glm::min(volume.resolution, ivec3(most)));
        return texels;
    };
    int most = kMaxProxyResolution;
    while (most > 1 && texelsWithin(most) > std::size_t(kMaxProxyTexels)) most /= 2;
    for (auto& volume : plan.volumes) volume.resolution = glm::min(volume.resolution, ivec3(most));

    std::stable_sort(automatic.begin(), automatic.end(),
                     [](const auto& a, const auto& b) { return texelCount(a.second) > texelCount(b.second); });
    std::size_t texels = 0;
    for (const auto& [i, resolution] : automatic) {
        if (texels + texelCount(resolution) > std::size_t(kMaxAutomaticProxyTexels)) continue;
        texels += texelCount(resolution);
        add({i}, false, resolution);
    }
    return plan;
}

ProxyVolume makeProxyVolume(const ProbeInterpolator& probes, const Scene& scene, std::span<const Bounds> meshBounds,
                            const ProxyVolumePlan::Volume& volume)
{
    const ProxyVolumeSettings settings{volume.resolution};
    if (volume.alongWorldAxes) return makeProxyVolume(probes, worldBoxOf(scene, meshBounds, volume.objects), settings);
    const Object& object = scene.objects[volume.objects.front()];
    return makeProxyVolume(probes, meshBounds[std::size_t(object.mesh)], object.worldFromObject, settings);
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
    for (std::size_t k = 0; k < sample.occlusion.layers.size(); ++k)
        sample.occlusion.layers[k] = sum[occlusionTexture(k)];
    sample.radiance[8] = vec3(sum[7]);
    return sample;
}

} // namespace halflight
