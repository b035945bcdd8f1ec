#include "halflight/bake_cpu/embree_integrator.h"

#include "bake/stages.h"
#include "bake_cpu/sample/path_tracer.h"

#include "halflight/base/parallel.h"

#include <cmath>

namespace halflight {

Result<ImageRgb32f> renderReference(const Scene& scene, const Camera& camera, ivec2 size, int samplesPerPixel,
                                    int bounces, uint32_t seed, const Progress& progress)
{
    const BakeGeometry geometry = flattenGeometry(scene, 1, GeometryFilter::All);
    const PathTracer paths(scene, geometry, LightUse::Reference);
    if (progress.cancelled()) return Error{ErrorCode::Cancelled, "interrupted"};
    if (!paths.ok()) return Error{ErrorCode::DeviceFailed, "Embree could not build the scene (out of memory?)"};

    const float aspect = float(size.x) / float(size.y);
    const float halfHeight =
        camera.orthographic ? 0.5f * camera.orthographicHeightMeters : std::tan(0.5f * camera.verticalFovRadians);
    const mat3 worldFromCamera(camera.worldFromCamera);
    const vec3 eye(camera.worldFromCamera[3]);
    ImageRgb32f picture(size.x, size.y);
    const bool finished =
        parallelFor(picture.texelCount(), 256, progress, "reference", [&](std::size_t begin, std::size_t end) {
            uint64_t rays = 0;
            for (std::size_t i = begin; i < end && !progress.cancelled(); ++i) {
                const vec2 pixel(float(i % std::size_t(size.x)), float(i / std::size_t(size.x)));
                vec3 sum(0.0f);
                for (int s = 0; s < samplesPerPixel && !progress.cancelled(); ++s) {
                    Sampler sampler(seed, uint32_t(i), uint32_t(s));
                    // Box filter over the pixel; the camera looks along -Z with +Y up.
                    const vec2 ndc = (pixel + sampler.next2()) / vec2(size) * vec2(2.0f, -2.0f) + vec2(-1.0f, 1.0f);
                    const vec3 onPlane(ndc.x * aspect * halfHeight, ndc.y * halfHeight, -1.0f);
                    vec3 origin = eye;
                    vec3 direction = worldFromCamera * vec3(0.0f, 0.0f, -1.0f);
                    float nearest = camera.nearMeters;
                    if (camera.orthographic) {
                        origin += worldFromCamera * vec3(onPlane.x, onPlane.y, 0.0f);
                    } else {
                        direction = worldFromCamera * onPlane;
                        nearest *= glm::length(direction);
                    }
                    direction = glm::normalize(direction);
                    sum += paths.cameraRadiance(origin + direction * nearest, direction, kInfinity, bounces, sampler,
                                                rays);
                }
                picture.data()[i] = sum / float(samplesPerPixel);
            }
        });
    if (!finished) return Error{ErrorCode::Cancelled, "interrupted"};
    return picture;
}

} // namespace halflight
