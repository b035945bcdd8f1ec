#include "bake/cache/cached_integrator.h"

#include "bake/geometry/indices.h"
#include "bake/settings/quality.h"

#include "halflight/scene/fingerprint.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {
namespace {

constexpr uint32_t kCacheVersion = 48; ///< raised when estimates of the same input change

/// Relative difference of a tile's check samples that counts as a change; well below the noise of a bake.
constexpr double kCheckTolerance = 0.005;

int checkSamples(int samples)
{
    return std::clamp(samples / 24, 2, 8);
}

/// `difference` and `before`: sums of absolute differences and of absolute values.
bool differ(double difference, double before)
{
    return !(difference <= kCheckTolerance * before); // NaN differs
}

/// Check samples of luminance, of which items have `perItem` each: of all light and of each component. Each must agree
/// by itself, as a group may be seen alone.
bool luminanceDiffers(std::span<const float> before, std::span<const float> now, std::size_t perItem)
{
    for (std::size_t c = 0; c < perItem; ++c) {
        double difference = 0.0;
        double sum = 0.0;
        for (std::size_t i = c; i < before.size(); i += perItem) {
            difference += std::abs(double(now[i]) - double(before[i]));
            sum += std::abs(double(before[i]));
        }
        if (differ(difference, sum)) return true;
    }
    return false;
}

bool probesDiffer(std::span<const ProbeEstimate> before, std::span<const ProbeEstimate> now)
{
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (before[i].valid != now[i].valid || before[i].occlusion != now[i].occlusion) return true;
        double difference = 0.0;
        for (std::size_t k = 0; k < 9; ++k)
            difference += double(glm::length(now[i].radiance[k] - before[i].radiance[k]));
        if (differ(difference, double(glm::length(before[i].radiance[0])))) return true;
    }
    return false;
}

/// Which source is of which component. A bake of some objects keeps the others' tiles unchecked, so that components
/// must mean the same.
void addMembers(Hasher& hasher, const LightComponents& components, const Scene& scene)
{
    if (components.count == 0) return;
    hasher.add(components.count);
    for (const int part : components.ofSky) hasher.add(part);
    const auto add = [&](int component, const std::string& name) {
        if (component > 0) hasher.add(component).add(std::string_view(name));
    };
    for (std::size_t i = 0; i < components.ofLight.size(); ++i) add(components.ofLight[i], scene.lights[i].name);
    for (std::size_t i = 0; i < components.ofMaterial.size(); ++i)
        add(components.ofMaterial[i], scene.materials[i].name);
}

/// Puts each value of `all` before its components, which `out` has then by item.
template<typename T> void interleave(std::span<const T> all, std::span<const T> components, std::span<T> out)
{
    const std::size_t count = all.empty() ? 0 : components.size() / all.size();
    for (std::size_t i = 0; i < all.size(); ++i) {
        out[i * (count + 1)] = all[i];
        std::ranges::copy(components.subspan(i * count, count), out.begin() + std::ptrdiff_t(i * (count + 1) + 1));
    }
}

Hash128 surfaceHash(const BakeGeometry& geometry, const TexelMap& map, std::size_t first, std::size_t count)
{
    Hasher hasher;
    for (std::size_t i = first; i < first + count; ++i) {
        const Texel& texel = map.texels[i];
        hasher.add(texel.x).add(texel.y).add(texel.page).add(texel.chart).add(texel.validPoints);
        for (uint32_t f = texel.firstFragment; f < texel.firstFragment + texel.fragmentCount; ++f) {
            const TexelFragment& fragment = map.fragments[f];
            hasher.add(fragment.barycentric).add(fragment.area);
            const std::array<vec3, 3> corners = geometry.cornersOf(fragment.triangle);
            const std::array<vec3, 3> normals = geometry.normalsOf(fragment.triangle);
            for (std::size_t k = 0; k < 3; ++k) hasher.add(corners[k]).add(normals[k]);
        }
    }
    return hasher.hash();
}

} // namespace

Hash128 bakeHash(const Scene& scene, const BakeSettings& settings)
{
    // Structured bindings name every setting: a new setting is a compile error here. The hash leaves out settings that
    // qualityOf() replaces, those that change no byte of the output file, the instruction set, which is part of
    // the identity, `only`, and a time limit, with which no bake is kept.
    [[maybe_unused]] const auto& [mode, quality, samples, shadowSamples, bounces, glossyBounces, integrator,
                                  noiseTarget, seconds, clock, isa, uvMode, texelsPerMeter, lightmapSize, paddingTexels,
                                  twoSided, denoiser, directional, maskEncoding, mostMaskLayers, subtractiveMask,
                                  probeSpacingMeters, probeLayout, reflectionProbes, groups, threads, seed,
                                  imagesDirectory, cacheDirectory, mixedIdentities, only] = settings;
    const BakeQuality q = qualityOf(settings, scene);
    Hasher hasher;
    hasher.add(kCacheVersion).add(contentHash(scene)).add(int(mode)).add(int(integrator)).add(int(uvMode));
    hasher.add(q.samples).add(q.shadowSamples).add(q.bounces).add(q.lightmapSize).add(q.probeSamples);
    hasher.add(int(glossyBounces))
        .add(q.noiseTarget)
        .add(texelsPerMeter)
        .add(paddingTexels)
        .add(int(twoSided))
        .add(int(denoiser))
        .add(int(q.directional));
    hasher.add(int(maskEncoding))
        .add(mostMaskLayers)
        .add(int(subtractiveMask))
        .add(probeSpacingMeters)
        .add(int(probeLayout));
    hasher.add(int(reflectionProbes)).add(q.reflectionSize).add(int(groups));
    return hasher.add(seed).hash();
}

Hash128 layoutHash(const TexelMap& map, const IntegrationSettings& settings, MixedLightingMode mode, const Scene& scene)
{
    Hasher hasher;
    hasher.add(kCacheVersion).add(int(mode)).add(settings.samples).add(settings.shadowSamples).add(settings.bounces);
    hasher.add(int(settings.glossyBounces))
        .add(int(settings.integrator))
        .add(settings.cache.noiseTarget)
        .add(int(settings.cache.denoised))
        .add(settings.probeSamples)
        .add(settings.seed);
    hasher.add(map.pageSize).add(map.pageCount);
    for (const Texel& texel : map.texels) hasher.add(texel.x).add(texel.y).add(texel.page);
    addMembers(hasher, settings.components, scene);
    return hasher.hash();
}

Hash128 lightHash(Hash128 layout, const Scene& scene, const BakeGeometry& geometry)
{
    Hasher hasher;
    hasher.add(layout).add(geometry.triangles).add(geometry.positions).add(geometry.normals);
    for (const std::vector<vec2>& set : geometry.uv) hasher.add(set);
    hasher.add(geometry.colors).add(geometry.lightmapTexel);
    const std::vector<Hash128> materials = materialHashes(scene);
    for (const BakeGeometry::Part& part : geometry.parts) {
        hasher.add(materialHash(materials, part.material)).add(int(part.castShadows)).add(int(part.receiveShadows));
        hasher.add(part.firstTriangle).add(int(part.side));
        if (part.instance == BakeGeometry::kOwn) continue;
        const BakeGeometry::Instance& i = geometry.instances[part.instance];
        hasher.add(part.firstStored).add(i.linear).add(i.origin).add(i.texelScale).add(i.texelOffset);
    }
    hasher.add(geometry.texelSides);
    for (const Light& light : scene.lights) {
        hasher.add(lightHash(light)).add(int(light.baking.bakeType)).add(light.baking.occlusionMaskChannel);
        if (light.baking.coloredMask) hasher.add(3); // channels
    }
    addSky(hasher, scene.sky);
    return hasher.hash();
}

BakeCache::Work<IrradianceEstimate, float> CachedIntegrator::irradianceWork(PreparedLightmap& lightmap) const
{
    BakeCache::Work<IrradianceEstimate, float> work;
    work.stage = work.progressName = "lightmap";
    work.count = map.texels.size();
    work.tileSize = kTexelTile;
    work.tilesPerPart = texelTilesPerPart(Tiling{work.count, work.tileSize}.tileCount());
    work.surface = [&](std::size_t first, std::size_t count) { return surfaceHash(geometry, map, first, count); };
    work.chosen = chosen;
    work.perItem = 1 + componentCount();
    work.compute = [&](std::span<const uint32_t> items, std::span<IrradianceEstimate> values, const Progress& part) {
        return estimatesOf(lightmap, {items}, values, part);
    };
    const int samples = checkSamples(settings.samples);
    const int shadowSamples = checkSamples(settings.shadowSamples);
    work.check = [this, &lightmap, samples, shadowSamples](std::span<const uint32_t> items, std::span<float> values,
                                                           const Progress& part) -> Status {
        std::vector<IrradianceEstimate> estimates(values.size());
        if (Status s = estimatesOf(lightmap, {items, samples, shadowSamples}, estimates, part); !s) return s;
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = luminance(estimates[i].irradiance);
        return {};
    };
    work.changed = [perItem = work.perItem](std::span<const float> before, std::span<const float> now) {
        return luminanceDiffers(before, now, perItem);
    };
    return work;
}

std::string maskStage(int layer)
{
    return layer == 0 ? "shadowmask" : "shadowmask" + std::to_string(layer);
}

BakeCache::Work<vec4, vec4> CachedIntegrator::shadowmaskWork(int layer) const
{
    BakeCache::Work<vec4, vec4> work;
    work.stage = maskStage(layer);
    work.progressName = "shadowmask";
    work.count = map.texels.size();
    work.tileSize = kTexelTile;
    work.tilesPerPart = texelTilesPerPart(Tiling{work.count, work.tileSize}.tileCount());
    work.surface = [&](std::size_t first, std::size_t count) { return surfaceHash(geometry, map, first, count); };
    work.keeps = keepsMasks;
    if (keepsMasks) work.chosen = chosen;
    work.compute = [this, layer](std::span<const uint32_t> items, std::span<vec4> values, const Progress& part) {
        return integrator.shadowmask(map, {items}, layer, values, part);
    };
    work.check = [this, layer](std::span<const uint32_t> items, std::span<vec4> values, const Progress& part) {
        const TexelRequest request{items, 0, checkSamples(settings.shadowSamples)};
        return integrator.shadowmask(map, request, layer, values, part);
    };
    // With equal random numbers any difference is a ray with another result.
    work.changed = [](std::span<const vec4> before, std::span<const vec4> now) {
        return !std::equal(before.begin(), before.end(), now.begin());
    };
    return work;
}

std::unique_ptr<PreparedLightmap> CachedIntegrator::prepare() const
{
    return integrator.prepare(map, cache != nullptr ? &cache->parts() : nullptr);
}

Status CachedIntegrator::irradiance(PreparedLightmap& lightmap, std::span<IrradianceEstimate> out,
                                    const Progress& progress) const
{
    if (cache == nullptr) return lightmap.irradiance({allIndices(map.texels.size())}, out, progress);
    return cache->run(irradianceWork(lightmap), out, progress);
}

Status CachedIntegrator::estimatesOf(PreparedLightmap& lightmap, const TexelRequest& request,
                                     std::span<IrradianceEstimate> out, const Progress& progress) const
{
    const std::size_t count = componentCount();
    if (count == 0) return lightmap.irradiance(request, out, progress);
    std::vector<IrradianceEstimate> all(request.texels.size());
    std::vector<IrradianceEstimate> components(all.size() * count);
    if (Status s = lightmap.irradianceByComponent(request, all, components, progress); !s) return s;
    interleave<IrradianceEstimate>(all, components, out);
    return {};
}

// Estimates of all components take much more memory than what is kept of them.
Status CachedIntegrator::irradianceByComponent(PreparedLightmap& lightmap, std::span<IrradianceEstimate> out,
                                               ComponentSignals& components, const Progress& progress) const
{
    if (cache != nullptr) return irradianceOfParts(lightmap, {}, out, components, progress);
    // Texels: four parts of the lightmap's, which fill all threads.
    constexpr std::size_t kAtOnce = std::size_t(1) << 18;
    const std::vector<uint32_t> all = allIndices(map.texels.size());
    std::vector<IrradianceEstimate> some;
    for (std::size_t first = 0; first < all.size(); first += kAtOnce) {
        const std::span<const uint32_t> texels = std::span(all).subspan(first, std::min(kAtOnce, all.size() - first));
        const double share = 1.0 / double(all.size());
        const Progress part = partOf(progress, double(first) * share, double(first + texels.size()) * share);
        some.resize(texels.size() * components.count());
        if (Status s = lightmap.irradianceByComponent({texels}, out.subspan(first, texels.size()), some, part); !s)
            return s;
        forEachIndex(texels.size(), [&](std::size_t i) {
            components.set(first + i, std::span(some).subspan(i * components.count(), components.count()));
        });
    }
    return {};
}

Status CachedIntegrator::irradianceOfParts(PreparedLightmap& lightmap, std::span<const std::size_t> parts,
                                           std::span<IrradianceEstimate> out, ComponentSignals& components,
                                           const Progress& progress) const
{
    BakeCache::Work<IrradianceEstimate, float> work = irradianceWork(lightmap);
    work.take = [&](std::size_t first, std::span<const IrradianceEstimate> values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::size_t texel = first + i / work.perItem;
            const std::size_t c = i % work.perItem;
            if (c == 0)
                out[texel] = values[i];
            else
                components.set(texel, c - 1, values[i]);
        }
    };
    const std::span<IrradianceEstimate> taken; // in place of a list
    return parts.empty() ? cache->run(work, taken, progress) : cache->run(work, parts, taken, progress);
}

Status CachedIntegrator::shadowmask(int layer, std::span<vec4> out, const Progress& progress) const
{
    if (cache == nullptr) return integrator.shadowmask(map, {allIndices(map.texels.size())}, layer, out, progress);
    return cache->run(shadowmaskWork(layer), out, progress);
}

Status CachedIntegrator::fillIrradiance(PreparedLightmap& lightmap, std::span<const std::size_t> parts,
                                        const Progress& progress) const
{
    return cache->fill(irradianceWork(lightmap), parts, progress);
}

Status CachedIntegrator::fillShadowmasks(int layers, std::span<const std::size_t> parts, const Progress& progress) const
{
    for (int layer = 0; layer < layers; ++layer)
        if (Status s = cache->fill(shadowmaskWork(layer), parts, progress); !s) return s;
    return {};
}

Status CachedIntegrator::estimatesOf(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                                     std::size_t components, std::span<ProbeEstimate> out,
                                     const Progress& progress) const
{
    if (components == 0) return integrator.probes(positions, which, samples, out, progress);
    std::vector<ProbeEstimate> all(which.size());
    std::vector<SphericalHarmonicsL2> light(all.size() * components);
    if (Status s = integrator.probesByComponent(positions, which, samples, all, light, progress); !s) return s;
    std::vector<ProbeEstimate> ofComponents;
    for (const SphericalHarmonicsL2& radiance : light) ofComponents.push_back({radiance, {}, 0.0f, true});
    interleave<ProbeEstimate>(all, ofComponents, out);
    return {};
}

Status CachedIntegrator::probes(std::span<const vec3> positions, std::span<ProbeEstimate> out, int batch,
                                const Progress& progress) const
{
    return probesByComponent(positions, out, {}, batch, progress);
}

Status CachedIntegrator::probesByComponent(std::span<const vec3> positions, std::span<ProbeEstimate> out,
                                           std::span<SphericalHarmonicsL2> components, int batch,
                                           const Progress& progress) const
{
    const std::vector<uint32_t> all = allIndices(positions.size());
    if (cache == nullptr) {
        return components.empty() ? integrator.probes(positions, all, 0, out, progress)
                                  : integrator.probesByComponent(positions, all, 0, out, components, progress);
    }
    const std::size_t count = components.empty() ? 0 : componentCount();
    BakeCache::Work<ProbeEstimate, ProbeEstimate> work;
    work.stage = "probes" + std::to_string(batch);
    work.progressName = "probes";
    work.count = positions.size();
    work.tileSize = kProbeTile;
    work.tilesPerPart = kProbeTilesPerPart;
    work.perItem = 1 + count;
    work.keeps = keepsMasks;
    work.surface = [&](std::size_t first, std::size_t size) {
        return Hasher().bytes(&positions[first], size * sizeof(vec3)).hash();
    };
    work.compute = [&](std::span<const uint32_t> items, std::span<ProbeEstimate> values, const Progress& part) {
        return estimatesOf(positions, items, 0, count, values, part);
    };
    const int samples = std::max(settings.probeSamples / 4, 16);
    work.check = [&](std::span<const uint32_t> items, std::span<ProbeEstimate> values, const Progress& part) {
        return estimatesOf(positions, items, samples, count, values, part);
    };
    work.changed = probesDiffer;
    work.take = [&](std::size_t first, std::span<const ProbeEstimate> values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::size_t item = first + i / work.perItem;
            if (const std::size_t c = i % work.perItem; c == 0) {
                out[item] = values[i];
            } else {
                components[item * count + c - 1] = values[i].radiance;
            }
        }
    };
    return cache->run(work, {}, progress);
}

} // namespace halflight
