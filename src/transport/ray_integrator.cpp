// Wires the stages of this folder to the Integrator interface.

#include "transport/ray_integrator.h"

#include "transport/lightmap/cached_lightmap.h"
#include "transport/lightmap/path_lightmap.h"
#include "transport/probes.h"
#include "transport/reflections.h"
#include "transport/segments.h"
#include "transport/shadows/baked_lights.h"
#include "transport/shadows/colored_shadows.h"
#include "transport/shadows/mask_layer.h"
#include "transport/shadows/shadow_pass.h"
#include "transport/texels/valid_points.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <utility>

namespace halflight {
namespace {

constexpr uint32_t kDirectSeed = 0x5eed0002u;
class RayIntegrator final : public Integrator {
public:
    RayIntegrator(const Scene& scene, const BakeGeometry& geometry, const IntegrationSettings& settings,
                  const MakeKernels& makeKernels)
        : settings_(settings),
          paths_(scene, geometry, LightUse::Bake, settings.glossyBounces ? Bounces::Glossy : Bounces::Diffuse,
                 makeKernels, settings.components),
          pattern_(settings.seed)
    {}

    [[nodiscard]] bool ok() const { return paths_.ok(); }

    [[nodiscard]] std::string description() const override
    {
        const bool cache = settings_.integrator == IntegratorKind::Cache;
        return paths_.surfaces().kernels().describe(cache ? "radiance cache" : "path tracing");
    }

    [[nodiscard]] uint64_t raysTraced() const override { return rays_.load(); }

    Status findValidPoints(TexelMap& map, PartFolder* parts, const Progress& progress) override
    {
        return halflight::findValidPoints(paths_, map, Store(parts), progress, rays_);
    }
    Status findValidPoints(std::span<const SurfacePoint> points, std::span<uint8_t> out) const override
    {
        return halflight::findValidPoints(paths_, points, out);
    }

    std::unique_ptr<PreparedLightmap> prepare(const TexelMap& map, PartFolder* parts) override;

    Status coloredShadows(const TexelMap& map, std::span<float> shares, const Progress& progress) override
    {
        return traceColoredShadows(paths_, pattern_, map, settings_.seed ^ kShadowSeed, shares, progress, rays_);
    }

    Status shadowmask(const TexelMap& map, const TexelRequest& request, int layer, std::span<vec4> out,
                      const Progress& progress) override
    {
        const auto device = deviceShadows();
        if (!device) return device.error();
        const ShadowPass pass{
            paths_,   pattern_,     map,   gridOf(map), request.texels, shadowSamplesOf(request), kTimesOnMaskEdges,
            progress, "shadowmask", rays_, *device};
        return traceMaskLayer(pass, settings_.seed ^ kShadowSeed, layer, out);
    }

    Status probes(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                  std::span<ProbeEstimate> out, const Progress& progress) override
    {
        return probesByComponent(positions, which, samples, out, {}, progress);
    }

    Status probesByComponent(std::span<const vec3> positions, std::span<const uint32_t> which, int samples,
                             std::span<ProbeEstimate> out, std::span<SphericalHarmonicsL2> components,
                             const Progress& progress) override
    {
        const auto device = devicePaths();
        if (!device) return device.error();
        const std::vector<vec3> from = besideProbes(paths_.surfaces(), positions);
        if (*device != nullptr)
            return traceProbesOn(**device, paths_, settings_, from, which, samples, out, components, progress, rays_);
        return traceProbes(paths_, settings_, from, which, samples, out, components, progress, rays_);
    }

    Status radianceAround(vec3 position, std::span<const ImageRgb32f> lightmap, int rays, ImageRgb32f& map,
                          const Progress& progress) override
    {
        return traceRadianceAround({paths_, settings_, {&lightmap, 1}, rays}, position, {&map, 1}, progress, rays_);
    }

    Status radianceAroundByComponent(vec3 position, std::span<const std::span<const ImageRgb32f>> lightmaps, int rays,
                                     std::span<ImageRgb32f> maps, const Progress& progress) override
    {
        return traceRadianceAround({paths_, settings_, lightmaps, rays}, position, maps, progress, rays_);
    }

    Status specularLight(std::span<const SurfacePoint> points, std::span<const vec3> views,
                         std::span<SpecularEstimate> out, const Progress& progress) override
    {
        return traceSpecularLight(paths_, settings_, points, views, out, progress, rays_);
    }

    Status sides(std::span<const SurfacePoint> points, std::span<const vec3> eyes, int paths, int walks,
                 std::span<SideEstimate> out, const Progress& progress) override
    {
        return traceSides(paths_, settings_, points, eyes, paths, walks, out, progress, rays_);
    }

    Status surfacesAlong(std::span<const Segment> segments, std::span<std::optional<vec2>> out) const override
    {
        return traceSegments(paths_.surfaces(), segments, out);
    }

private:
    class Lightmap;

    [[nodiscard]] int shadowSamplesOf(const TexelRequest& request) const
    {
        return request.shadowSamples > 0 ? request.shadowSamples : settings_.shadowSamples;
    }

    const TexelGrid& gridOf(const TexelMap& map)
    {
        if (grid_ == nullptr || gridMap_ != &map || gridTexels_ != map.texels.size()) {
            grid_ = std::make_unique<TexelGrid>(map);
            gridMap_ = &map;
            gridTexels_ = map.texels.size();
        }
        return *grid_;
    }
    /// The device that traces shadow rays; null: the processor does.
    Result<const DeviceShadows*> deviceShadows()
    {
        if (!shadows_) {
            const ShadowTables tables{paths_.surfaces(), paths_.light().lights(), pattern_};
            auto made = paths_.surfaces().kernels().prepareShadows(tables);
            if (!made) return made.error();
            shadows_ = std::move(*made);
        }
        return static_cast<const DeviceShadows*>(shadows_->get());
    }

    /// The device that traces whole paths; null: the processor does.
    Result<const DevicePaths*> devicePaths()
    {
        if (!devicePaths_) {
            auto made = paths_.surfaces().kernels().preparePaths(paths_, settings_.bounces);
            if (!made) return made.error();
            devicePaths_ = std::move(*made);
        }
        return static_cast<const DevicePaths*>(devicePaths_->get());
    }

    IntegrationSettings settings_;
    PathTracer paths_;
    StratifiedPattern pattern_;
    std::unique_ptr<TexelGrid> grid_; ///< of the map of the last call
    const TexelMap* gridMap_ = nullptr;
    std::size_t gridTexels_ = 0;
    std::optional<std::unique_ptr<DeviceShadows>> shadows_;   ///< deviceShadows(), once it was asked for
    std::optional<std::unique_ptr<DevicePaths>> devicePaths_; ///< devicePaths(), once it was asked for
    std::atomic<uint64_t> rays_{0};
};

class RayIntegrator::Lightmap final : public PreparedLightmap {
public:
    Lightmap(RayIntegrator& integrator, const TexelMap& map, Store store)
        : all_(integrator), map_(map), cached_(all_.paths_, all_.pattern_, all_.settings_, map, store)
    {}

    Status irradiance(const TexelRequest& request, std::span<IrradianceEstimate> out, const Progress& progress) override
    {
        return irradianceByComponent(request, out, {}, progress);
    }
    Status irradianceByComponent(const TexelRequest& request, std::span<IrradianceEstimate> texels,
                                 std::span<IrradianceEstimate> components, const Progress& progress) override
    {
        const TexelLight out{texels, components};
        if (Status s = withoutBakedLights(request, out, progress); !s || request.rough) return s;
        const auto device = all_.deviceShadows();
        if (!device) return device.error();
        const ShadowPass pass{all_.paths_,        all_.pattern_,  map_,
                              all_.gridOf(map_),  request.texels, all_.shadowSamplesOf(request),
                              kTimesOnLightEdges, progress,       "lights",
                              all_.rays_,         *device};
        return addBakedLights(pass, all_.settings_.seed ^ kDirectSeed, out);
    }
    Status prepareAll(const Progress& progress) override
    {
        return isCached() ? cached_.prepareAll(progress, all_.rays_) : Status();
    }
    Status prepareParts(const Progress& progress) override
    {
        return isCached() ? cached_.prepareParts(progress, all_.rays_) : Status();
    }

    bool setSamples(int samples) override
    {
        const int before = std::exchange(all_.settings_.samples, samples);
        return cached_.samplesChanged(before);
    }

private:
    [[nodiscard]] bool isCached() const { return all_.settings_.integrator == IntegratorKind::Cache; }
    Status withoutBakedLights(const TexelRequest& request, const TexelLight& out, const Progress& progress)
    {
        const int samples = request.samples > 0 ? request.samples : all_.settings_.samples;
        if (request.rough)
            return traceRoughLightmap(all_.paths_, all_.settings_, map_, request.texels, samples, out.texels, progress,
                                      all_.rays_);
        if (isCached())
            return cached_.irradiance(request.texels, samples, out.texels, out.components, progress, all_.rays_);
        const auto device = all_.devicePaths();
        if (!device) return device.error();
        if (*device != nullptr)
            return tracePathLightmapOn(**device, all_.paths_, all_.settings_, map_, request.texels, samples, out,
                                       progress, all_.rays_);
        return tracePathLightmap(all_.paths_, all_.settings_, map_, request.texels, samples, out, progress, all_.rays_);
    }

    RayIntegrator& all_;
    const TexelMap& map_;
    CachedLightmap cached_;
};

std::unique_ptr<PreparedLightmap> RayIntegrator::prepare(const TexelMap& map, PartFolder* parts)
{
    return std::make_unique<Lightmap>(*this, map, Store(parts));
}

} // namespace

std::unique_ptr<Integrator> makeRayIntegrator(const Scene& scene, const BakeGeometry& geometry,
                                              const IntegrationSettings& settings, const MakeKernels& makeKernels)
{
    auto integrator = std::make_unique<RayIntegrator>(scene, geometry, settings, makeKernels);
    return integrator->ok() ? std::move(integrator) : nullptr;
}

} // namespace halflight
