#include "halflight/bake_cpu/embree_integrator.h"

#include "bake/geometry/flatten.h"
#include "bake_cpu/reference/reference_tracer.h"
#include "bake_cpu/trace/embree_kernels.h"

#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"

#include <algorithm>

namespace halflight {
namespace {

struct CameraRay {
    vec3 origin{0.0f}; ///< on the near plane
    vec3 direction{0.0f, 0.0f, -1.0f};
};

/// `place`: of the picture, (0, 0) its upper left corner, (1, 1) the lower right one.
CameraRay cameraRay(const Camera& camera, float aspect, vec2 place)
{
    // The camera's axis is -Z; +Y is up.
    const float halfHeight =
        camera.orthographic ? 0.5f * camera.orthographicHeightMeters : math::tan(0.5f * camera.verticalFovRadians);
    const vec2 ndc = place * vec2(2.0f, -2.0f) + vec2(-1.0f, 1.0f);
    const vec3 onPlane(ndc.x * aspect * halfHeight, ndc.y * halfHeight, -1.0f);
    const mat3 worldFromCamera(camera.worldFromCamera);
    CameraRay ray{vec3(camera.worldFromCamera[3]), worldFromCamera * vec3(0.0f, 0.0f, -1.0f)};
    float nearest = camera.nearMeters;
    if (camera.orthographic) {
        ray.origin += worldFromCamera * vec3(onPlane.x, onPlane.y, 0.0f);
    } else {
        ray.direction = worldFromCamera * onPlane;
        nearest *= glm::length(ray.direction);
    }
    ray.direction = glm::normalize(ray.direction);
    ray.origin += ray.direction * nearest;
    return ray;
}

} // namespace

struct ReferenceRenderer::Impl {
    explicit Impl(const Scene& of)
        : scene(of), geometry(flattenGeometry(of, 1, GeometryFilter::All)),
          paths(of, geometry, LightUse::Reference, Bounces::Diffuse, embreeKernels())
    {}

    const Scene& scene;
    BakeGeometry geometry;
    PathTracer paths;
};

ReferenceRenderer::ReferenceRenderer() = default;
ReferenceRenderer::~ReferenceRenderer() = default;

Result<std::unique_ptr<ReferenceRenderer>> ReferenceRenderer::create(const Scene& scene)
{
    std::unique_ptr<ReferenceRenderer> renderer(new ReferenceRenderer);
    renderer->impl_ = std::make_unique<Impl>(scene);
    if (!renderer->impl_->paths.ok())
        return Error{ErrorCode::DeviceFailed, "Embree could not build the scene (out of memory?)"};
    return renderer;
}

Result<ImageRgb32f> ReferenceRenderer::render(const Camera& camera, ivec2 size, const ReferenceSettings& settings,
                                              const Progress& progress) const
{
    const ReferenceTracer tracer(impl_->scene, impl_->paths, {settings.surfaces, settings.clampNits});

    const float aspect = float(size.x) / float(size.y);
    ImageRgb32f picture(size.x, size.y);
    // Pixels of one task: few where each takes long, so that the progress moves.
    const auto pixels = std::size_t(std::clamp(32768 / settings.samplesPerPixel, 1, 256));
    const bool finished =
        parallelFor(picture.texelCount(), pixels, progress, "reference", [&](std::size_t begin, std::size_t end) {
            uint64_t rays = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const vec2 pixel(float(i % std::size_t(size.x)), float(i / std::size_t(size.x)));
                glm::dvec3 sum(0.0);
                for (int s = 0; s < settings.samplesPerPixel; ++s) {
                    if (progress.cancelled()) return;
                    Sampler sampler(settings.seed, uint32_t(i), uint32_t(s));
                    const CameraRay ray = cameraRay(camera, aspect, (pixel + sampler.next2()) / vec2(size));
                    sum += glm::dvec3(
                        tracer.radiance(ray.origin, ray.direction, RayUse::Camera, settings.bounces, sampler, rays));
                }
                picture.data()[i] = vec3(sum / double(settings.samplesPerPixel));
            }
        });
    if (Status s = impl_->paths.surfaces().outcome(finished); !s) return s.error();
    return picture;
}

Result<ImageRgb32f> renderReference(const Scene& scene, const Camera& camera, ivec2 size,
                                    const ReferenceSettings& settings, const Progress& progress)
{
    Result<std::unique_ptr<ReferenceRenderer>> renderer = ReferenceRenderer::create(scene);
    if (!renderer) return renderer.error();
    return (*renderer)->render(camera, size, settings, progress);
}

} // namespace halflight
