// What importance sampling of a sky's picture and of area lights gains: the error of the same estimator, path tracing
// of the reference, at equal CPU time with and without it. Usage:
//
//   bench_importance [SCENE.glb]
//
// Without: all light is met by directions of the BRDF (EmitterSampling::Directions). With: multiple importance sampling
// with directions to the sky's bright places and points of the lights (EmitterSampling::Both), as bakes, probes and
// references sample them. The light is of one kind each time: all others are removed.
#include "bake/geometry/flatten.h"
#include "bake_cpu/reference/reference_tracer.h"
#include "bake_cpu/trace/embree_kernels.h"

#include "halflight/base/parallel.h"
#include "halflight/scene/gltf.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>

using namespace halflight;

namespace {

constexpr int kBounces = 2;
constexpr int kSamples = 256; // of a point, in each of the two ways
constexpr int kTruthSamples = 4096;
constexpr std::size_t kPoints = 600;

double cpuSeconds()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}

/// A day: 1000 cd/m2 above the horizon, and a sun of 4 degrees, 45 degrees up, that gives as much light as that.
Sky day()
{
    auto picture = std::make_shared<ImageRgb32f>(512, 256);
    for (int y = 0; y < 256; ++y) {
        for (int x = 0; x < 512; ++x) {
            const float up = kPi * (0.5f - (float(y) + 0.5f) / 256.0f);
            const float around = 2.0f * kPi * ((float(x) + 0.5f) / 512.0f);
            const vec3 direction(std::cos(up) * std::cos(around), std::sin(up), std::cos(up) * std::sin(around));
            const bool sun = dot(direction, normalize(vec3(1, 1.4f, 1))) > std::cos(glm::radians(2.0f));
            (*picture)(x, y) = vec3(sun ? 1.0e6f : up > 0.0f ? 1000.0f : 200.0f);
        }
    }
    Sky sky;
    sky.setPicture(picture, 0.0f);
    return sky;
}

/// Two panels, a rectangle and a disk, half a metre wide, 3 m above the ground.
void addPanels(Scene& scene)
{
    for (const float side : {-1.5f, 1.5f}) {
        Light light;
        light.type = side < 0.0f ? LightType::Rectangle : LightType::Disk;
        light.sizeMeters = vec2(0.5f);
        light.intensity = 5000.0f;
        light.worldFromLight = mat4(vec4(1, 0, 0, 0), vec4(0, 0, -1, 0), vec4(0, 1, 0, 0), vec4(side, 3.0f, side, 1));
        scene.lights.push_back(light);
    }
}

struct Estimate {
    std::vector<double> luminances; ///< of the points
    double seconds = 0.0;           ///< CPU time
};

/// Radiance towards the scene's first camera at points spread over its picture (R2 sequence, Roberts 2018).
class Points {
public:
    explicit Points(const Scene& scene)
        : scene_(scene), geometry_(flattenGeometry(scene, 1, GeometryFilter::All)),
          paths_(scene, geometry_, LightUse::Reference, Bounces::Diffuse, embreeKernels())
    {}
    [[nodiscard]] Estimate estimate(EmitterSampling emitters, int samples, uint32_t seed) const
    {
        const ReferenceTracer tracer(scene_, paths_, {.emitters = emitters});
        const Camera& camera = scene_.cameras.front();
        const float halfHeight = std::tan(0.5f * camera.verticalFovRadians);
        Estimate result;
        result.luminances.resize(kPoints);
        const double start = cpuSeconds();
        parallelFor(kPoints, 1, [&](std::size_t begin, std::size_t end) {
            uint64_t rays = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const vec2 at = 2.0f * fract(vec2(0.5f) + float(i) * vec2(0.7548776662f, 0.5698402910f)) - 1.0f;
                const vec3 direction = normalize(mat3(camera.worldFromCamera) *
                                                 vec3(at.x * halfHeight * 16.0f / 9.0f, at.y * halfHeight, -1.0f));
                double sum = 0.0;
                for (int s = 0; s < samples; ++s) {
                    Sampler sampler(seed, uint32_t(i), uint32_t(s));
                    sum += double(luminance(tracer.radiance(vec3(camera.worldFromCamera[3]), direction, RayUse::Camera,
                                                            kBounces, sampler, rays)));
                }
                result.luminances[i] = sum / samples;
            }
        });
        result.seconds = cpuSeconds() - start;
        return result;
    }

private:
    const Scene& scene_;
    BakeGeometry geometry_;
    PathTracer paths_;
};

double relativeError(const Estimate& found, const Estimate& truth)
{
    double squares = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < kPoints; ++i) {
        squares += std::pow(found.luminances[i] - truth.luminances[i], 2.0);
        sum += truth.luminances[i];
    }
    return std::sqrt(squares / kPoints) / (sum / kPoints);
}

void compare(const char* light, const Scene& scene)
{
    const Points points(scene);
    const Estimate truth = points.estimate(EmitterSampling::Both, kTruthSamples, 1);
    const Estimate with = points.estimate(EmitterSampling::Both, kSamples, 2);
    const Estimate without = points.estimate(EmitterSampling::Directions, kSamples, 3);
    const double a = relativeError(with, truth);
    const double b = relativeError(without, truth);
    const double longer = without.seconds / with.seconds * (b / a) * (b / a);
    std::printf("| %s | %.1f %% in %.2f s | %.1f %% in %.2f s | %.1f | %.0f |\n", light, 100.0 * b, without.seconds,
                100.0 * a, with.seconds, std::sqrt(longer), longer);
}

} // namespace

int main(int count, char** values)
{
    const char* file = count > 1 ? values[1] : "assets/courtyard.glb";
    Result<Scene> read = readScene(file);
    if (!read || read->cameras.empty()) {
        std::fprintf(stderr, "%s: %s\n", file, read ? "has no camera" : read.error().text().c_str());
        return 1;
    }
    Scene dark = std::move(*read);
    dark.lights.clear();
    dark.sky = {};
    for (Material& material : dark.materials) material.emissiveNits = vec3(0.0f);
    Scene underSky = dark;
    underSky.sky = day();
    Scene underPanels = std::move(dark);
    addPanels(underPanels);
    std::printf(
        "| light | error without, %d samples | with | noise at equal time, without / with | time to equal noise |\n"
        "|---|---|---|---|---|\n",
        kSamples);
    compare("picture of the sky with a sun", underSky);
    compare("two area lights", underPanels);
    return 0;
}
