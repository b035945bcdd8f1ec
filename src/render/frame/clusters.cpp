// Lights by cluster of the view frustum: Olsson, Billeter and Assarsson 2012, "Clustered Deferred and Forward Shading",
// with exponential depth slices.
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

constexpr ivec3 kClusterGrid{16, 9, 24};

/// Boxes are this much (relative) larger than their clusters, since a shader's log2 and division may round otherwise.
constexpr float kRoundingMargin = 1.0e-3f;

/// View-space boxes of all clusters, in the order of LightClusters::words.
std::vector<Bounds> clusterBoxes(const LightClusters& clusters, const FrameView& view)
{
    const Camera& camera = view.camera;
    const float aspect = float(std::max(view.size.x, 1)) / float(std::max(view.size.y, 1));
    const float halfY =
        camera.orthographic ? 0.5f * camera.orthographicHeightMeters : std::tan(0.5f * camera.verticalFovRadians);
    const vec2 half(halfY * aspect, halfY);
    const vec2 step = 2.0f / vec2(clusters.size.x, clusters.size.y);
    std::vector<Bounds> boxes;
    boxes.reserve(std::size_t(clusters.size.x) * std::size_t(clusters.size.y) * std::size_t(clusters.size.z));
    const float ratio = clusters.farMeters / clusters.nearMeters;
    for (int z = 0; z < clusters.size.z; ++z) {
        float d0 = clusters.nearMeters * std::pow(ratio, float(z) / float(clusters.size.z)) * (1.0f - kRoundingMargin);
        float d1 =
            clusters.nearMeters * std::pow(ratio, float(z + 1) / float(clusters.size.z)) * (1.0f + kRoundingMargin);
        // The first slice takes all that is nearer, the last all that is farther.
        if (z == 0) d0 = std::min(d0, camera.orthographic ? camera.nearMeters : 0.0f);
        if (z == clusters.size.z - 1) d1 = std::max(d1, std::min(camera.farMeters, 1.0e7f));
        for (int y = 0; y < clusters.size.y; ++y) {
            for (int x = 0; x < clusters.size.x; ++x) {
                // Picture coordinates -1…1 with y down; view space has y up.
                const vec2 low = (-1.0f + step * vec2(x, y) - kRoundingMargin * step) * half;
                const vec2 high = (-1.0f + step * vec2(x + 1, y + 1) + kRoundingMargin * step) * half;
                Bounds box;
                for (const float depth : {d0, d1}) {
                    const float scale = camera.orthographic ? 1.0f : depth;
                    box.extend(vec3(low.x * scale, -high.y * scale, -depth));
                    box.extend(vec3(high.x * scale, -low.y * scale, -depth));
                }
                boxes.push_back(box);
            }
        }
    }
    return boxes;
}

} // namespace

ivec3 LightClusters::clusterAt(vec2 uv, float viewDepthMeters) const
{
    const float depth = std::max(viewDepthMeters, 1.0e-20f);
    const float slice = std::floor(std::log2(depth / nearMeters) * float(size.z) / std::log2(farMeters / nearMeters));
    return {std::clamp(int(std::floor(uv.x * float(size.x))), 0, size.x - 1),
            std::clamp(int(std::floor(uv.y * float(size.y))), 0, size.y - 1),
            int(std::clamp(slice, 0.0f, float(size.z - 1)))};
}

LightClusters clusterLights(const Scene& scene, const FrameView& view, const Bounds& sceneBounds,
                            std::span<const FrameLight> lights)
{
    const Camera& camera = view.camera;
    const mat4 viewFromWorld = view.viewFromWorld();
    LightClusters clusters;
    clusters.size = kClusterGrid;
    // Slices between the camera and the scene's far end.
    clusters.nearMeters = std::max(camera.nearMeters, 0.1f);
    float deepest = 0.0f;
    if (!sceneBounds.empty()) {
        const vec3 center = vec3(viewFromWorld * vec4(sceneBounds.center(), 1.0f));
        const vec3 axis = vec3(viewFromWorld[0].z, viewFromWorld[1].z, viewFromWorld[2].z);
        deepest = -center.z + glm::dot(glm::abs(axis), 0.5f * sceneBounds.size());
    }
    clusters.farMeters = std::max(std::min(deepest, camera.farMeters), 2.0f * clusters.nearMeters);

    const std::vector<Bounds> boxes = clusterBoxes(clusters, view);
    clusters.words.assign(boxes.size() * LightClusters::kWords, 0u);
    const std::size_t boxesPerSlice = std::size_t(kClusterGrid.x) * std::size_t(kClusterGrid.y);
    for (std::size_t n = 0; n < lights.size(); ++n) {
        LightVolume volume = volumeOf(scene.lights[std::size_t(lights[n].light)]);
        volume.center = vec3(viewFromWorld * vec4(volume.center, 1.0f));
        volume.axis = mat3(viewFromWorld) * volume.axis;
        const std::size_t word = n / 32;
        const uint32_t bit = 1u << (n % 32);
        for (std::size_t slice = 0; slice < boxes.size(); slice += boxesPerSlice) {
            // All boxes of a slice span the same depths.
            const Bounds& first = boxes[slice];
            if (!volume.everywhere && (volume.center.z - volume.radius > first.max.z + 1.0e-3f ||
                                       volume.center.z + volume.radius < first.min.z - 1.0e-3f)) {
                continue;
            }
            for (std::size_t i = slice; i < slice + boxesPerSlice; ++i) {
                if (meets(volume, boxes[i])) clusters.words[i * LightClusters::kWords + word] |= bit;
            }
        }
    }
    return clusters;
}

} // namespace halflight
