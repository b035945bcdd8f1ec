#pragma once
// The one way to trace rays. Everything else of the transport of light works on arrays, and knows no device.

#include "transport/trace/ray.h"
#include "transport/trace/ray_scene.h"

#include "halflight/base/result.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace halflight {

/// Light: both sides of every surface count, and objects that cast no shadow do not. Camera: rays pass through backs of
/// single-sided surfaces, as the renderer does, and hit objects that cast no shadow.
enum class RayUse { Light, Camera };

class DeviceGather;
class DevicePaths;
class DeviceRadiosity;
class DeviceShadows;
class DeviceValidity;
class PathTracer;
struct GatherTables;
struct PatchLayout;
struct RadiosityInput;
struct ShadowTables;

/// Traces batches of rays. A result depends on its ray alone, but for rounding: rays that belong together are faster in
/// one batch, and a batch of the same rays gives the same bits. `out` has one entry for each ray. All verbs may be
/// called by several threads at once. An error means that the device is lost: `out` is undefined then, and all later
/// calls fail too.
class RayKernels {
public:
    virtual ~RayKernels() = default;

    /// The nearest surface. A surface that covers part of its triangle is hit with that probability, by a hash of the
    /// ray. Where two surfaces lie back to back, a front is preferred to a hidden back. Light along the ray counts
    /// times RayHit::tint, also where nothing is hit: the colour of the glass that the ray passed, over the probability
    /// with which it passed.
    virtual Status nearest(std::span<const Ray> rays, std::span<RayHit> out, RayUse use = RayUse::Light) const = 0;
    /// Whether any shadow caster lies between tMin and tMax.
    virtual Status occluded(std::span<const Ray> rays, std::span<bool> out) const = 0;
    /// Fraction of light that passes, by colour: 0 behind an opaque surface, else the product of what the blended ones
    /// let through (Material::passed()) and of the volumes between.
    virtual Status transmittance(std::span<const Ray> rays, std::span<vec3> out) const = 0;
    /// Solids that a ray leaves on its way out of the scene, minus those that it enters; above 0, the origin is inside
    /// one. All surfaces count, however near to one another: solids may share a face. Those that let a part of light
    /// pass count by chance, as nearest() hits them. 0 for a ray through very many.
    virtual Status crossings(std::span<const Ray> rays, std::span<int> out) const = 0;

    /// Shadow casters whose bounds are within a distance of a point, some of them more than once, and perhaps others
    /// near it. False if there are more than `most`, or the kernels cannot say.
    virtual bool trianglesNear(vec3 /*center*/, float /*radius*/, std::size_t /*most*/,
                               std::vector<uint32_t>& /*triangles*/) const
    {
        return false;
    }
    /// The final gather of whole batches of texels (lightmap/device_gather.h); null where rays are traced by the verbs
    /// above. The kernels outlive it.
    [[nodiscard]] virtual Result<std::unique_ptr<DeviceGather>> prepareGather(const GatherTables& tables) const;
    /// Whole paths with up to `bounces` reflections (device_paths.h); null as above. `paths` has these kernels.
    [[nodiscard]] virtual Result<std::unique_ptr<DevicePaths>> preparePaths(const PathTracer& paths, int bounces) const;
    /// The rays of the radiosity passes (radiosity/device_radiosity.h); null as above. `layout`: of the patches, before
    /// the first pass.
    [[nodiscard]] virtual Result<std::unique_ptr<DeviceRadiosity>> prepareRadiosity(const RadiosityInput& input,
                                                                                    const PatchLayout& layout) const;
    /// Shadow rays of a map's texels (shadows/device_shadows.h); null as above.
    [[nodiscard]] virtual Result<std::unique_ptr<DeviceShadows>> prepareShadows(const ShadowTables& tables) const;
    /// Tests of sample points (texels/device_validity.h); null as above.
    [[nodiscard]] virtual Result<std::unique_ptr<DeviceValidity>> prepareValidity() const;
    /// One line for reports: what traces, and by which method, as "cpu (radiance cache, Embree 4.3.0, 16 threads)".
    [[nodiscard]] virtual std::string describe(const std::string& method) const = 0;
    /// Most bytes of the trees so far.
    [[nodiscard]] virtual std::size_t peakBytes() const = 0;
};

/// Makes kernels for a scene, which outlives them; null when the device failed or memory ran out.
using MakeKernels = std::function<std::unique_ptr<RayKernels>(const RayScene& scene)>;

} // namespace halflight
