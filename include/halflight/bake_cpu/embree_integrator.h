#pragma once

#include "halflight/bake/integrator.h"

namespace halflight {

/// The integrators of IntegratorKind on the CPU with Embree, on all cores.
Result<std::unique_ptr<Integrator>> makeEmbreeIntegrator(const Scene& scene, const BakeGeometry& geometry,
                                                         const IntegrationSettings& settings);

/// makeEmbreeIntegrator(), and its identity: Embree's version, the instruction set, and a hash of what rays of a small
/// fixed scene and functions of mathematics give on this machine.
IntegratorFactory embreeIntegrators();

/// How surfaces of a reference picture reflect.
enum class ReferenceSurfaces {
    Full,           ///< by glTF's BRDF (shading::reflectLight()), as the renderer shades them
    DiffuseView,    ///< those that the camera sees are diffuse, of shading::transportAlbedo(); later ones are not
    DiffuseBounces, ///< those that the camera sees by glTF's BRDF, later ones as in a bake without glossy bounces
    Diffuse,        ///< all are diffuse surfaces of shading::transportAlbedo()
};
/// `specularView`: of surfaces that the camera sees, as RenderSettings::specular; `specularBounces`: of later ones.
constexpr ReferenceSurfaces referenceSurfaces(bool specularView, bool specularBounces)
{
    if (specularView) return specularBounces ? ReferenceSurfaces::Full : ReferenceSurfaces::DiffuseBounces;
    return specularBounces ? ReferenceSurfaces::DiffuseView : ReferenceSurfaces::Diffuse;
}

struct ReferenceSettings {
    int samplesPerPixel = 64;  ///< at least 1
    int bounces = kAllBounces; ///< most reflections between a light source and the first surface, 0 or more
    uint32_t seed = 1;
    ReferenceSurfaces surfaces = ReferenceSurfaces::Full;
    /// Limit in nits of the luminance that a path brings at once by way of two or more surfaces: less noise, and too
    /// dark. 0 = none.
    float clampNits = 0.0f;
};

/// What `halflight render --reference SPP` draws with: the whole scene, static and dynamic, path traced from a camera.
/// Unbiased, but for the limit that the settings may have: textures at full resolution with bilinear filtering, normal
/// maps, alpha, all lights with their sizes, emissive surfaces, the sky.
class ReferenceRenderer {
public:
    /// Builds what rays are traced in; `scene` outlives the renderer.
    static Result<std::unique_ptr<ReferenceRenderer>> create(const Scene& scene);
    ~ReferenceRenderer();
    ReferenceRenderer(const ReferenceRenderer&) = delete;
    ReferenceRenderer& operator=(const ReferenceRenderer&) = delete;

    /// Linear radiance in nits; a pixel is the mean over its square. The result does not depend on the number of
    /// threads. Cancelling is looked at for each sample.
    [[nodiscard]] Result<ImageRgb32f> render(const Camera& camera, ivec2 size, const ReferenceSettings& settings,
                                             const Progress& progress = {}) const;

private:
    struct Impl;
    ReferenceRenderer();
    std::unique_ptr<Impl> impl_;
};

/// One picture of a ReferenceRenderer.
Result<ImageRgb32f> renderReference(const Scene& scene, const Camera& camera, ivec2 size,
                                    const ReferenceSettings& settings, const Progress& progress = {});

} // namespace halflight
