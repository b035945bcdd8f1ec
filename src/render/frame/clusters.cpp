// Lights by cluster of the view frustum: Olsson, Billeter and Assarsson 2012, "Clustered Deferred and Forward Shading",
// with exponential depth slices.
#include "halflight/base/mathematics.h"
#include "halflight/base/parallel.h"
#include "render/frame/frame_internal.h"

#include <algorithm>
#include <cmath>

namespace halflight {
namespace {

/// Fine enough that small lights are not asked after far beside them: 40 pixels of a 1920 x 1080 picture.
constexpr ivec3 kClusterGrid{48, 27, 24};

/// Boxes are this much (relative) larger than their clusters, since a shader's log2 and division may round otherwise.
constexpr float kRoundingMargin = 1.0e-3f;

/// What a picture coordinate -1…1 is in view space: x or y, at 1 m depth for perspective cameras.
vec2 halfExtent(const FrameView& view)
{
    const Camera& camera = view.camera;
    const float aspect = float(std::max(view.size.x, 1)) / float(std::max(view.size.y, 1));
    const float halfY =
        camera.orthographic ? 0.5f * camera.orthographicHeightMeters : math::tan(0.5f * camera.verticalFovRadians);
    return {halfY * aspect, halfY};
}

/// Side planes of a perspective camera's columns or rows of clusters, all through the eye. A slice is much deeper than
/// wide, so that far from the picture's middle a cluster's box holds many times what the cluster does.
class Wedges {
public:
    Wedges(int axis, int count, float half, bool yDown) : axis_(axis)
    {
        const float step = 2.0f / float(count);
        for (int i = 0; i < count; ++i) {
            const float low = (-1.0f + step * (float(i) - kRoundingMargin)) * half;
            const float high = (-1.0f + step * (float(i) + 1.0f + kRoundingMargin)) * half;
            bounds_.push_back(yDown ? vec2(-high, -low) : vec2(low, high));
        }
    }
    /// True only when no point of the ball is in wedge i. Of the plane x = -k z the normal is (1, k) / sqrt(1 + k^2).
    [[nodiscard]] bool misses(std::size_t i, vec3 center, float radius) const
    {
        const auto distance = [&](float k) { return (center[axis_] + k * center.z) / std::sqrt(1.0f + k * k); };
        return distance(bounds_[i].x) < -radius || distance(bounds_[i].y) > radius;
    }

private:
    int axis_;
    std::vector<vec2> bounds_;
};

/// View-space boxes of all clusters, in the order of LightClusters::words.
std::vector<Bounds> clusterBoxes(const LightClusters& clusters, const FrameView& view)
{
    const Camera& camera = view.camera;
    const vec2 half = halfExtent(view);
    const vec2 step = 2.0f / vec2(clusters.size.x, clusters.size.y);
    std::vector<Bounds> boxes;
    boxes.reserve(std::size_t(clusters.size.x) * std::size_t(clusters.size.y) * std::size_t(clusters.size.z));
    const float ratio = clusters.farMeters / clusters.nearMeters;
    for (int z = 0; z < clusters.size.z; ++z) {
        float d0 = clusters.nearMeters * math::pow(ratio, float(z) / float(clusters.size.z)) * (1.0f - kRoundingMargin);
        float d1 =
            clusters.nearMeters * math::pow(ratio, float(z + 1) / float(clusters.size.z)) * (1.0f + kRoundingMargin);
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

/// Bits of all lights in the clusters of one depth slice.
void fillSlice(std::span<const LightVolume> volumes, std::span<const Bounds> boxes, const Wedges* columns,
               const Wedges* rows, std::size_t z, std::vector<uint32_t>& words)
{
    constexpr float kMargin = 1.0e-3f; // of the quick tests, in metres
    const std::size_t width = std::size_t(kClusterGrid.x);
    const std::size_t first = z * width * std::size_t(kClusterGrid.y);
    const std::size_t last = first + width * std::size_t(kClusterGrid.y) - 1;
    Bounds slab = boxes[first];
    slab.extend(boxes[last]);
    for (std::size_t n = 0; n < volumes.size(); ++n) {
        const LightVolume& volume = volumes[n];
        const uint32_t bit = 1u << (n % 32);
        const auto mark = [&](std::size_t i) { words[i * LightClusters::kWords + n / 32] |= bit; };
        // How far a box may be from the light's centre along an axis.
        const float reach = volume.radius + kMargin;
        const auto beside = [&](const Bounds& box, int axis) {
            return volume.center[axis] - reach > box.max[axis] || volume.center[axis] + reach < box.min[axis];
        };
        const bool ball = !(volume.halfAngle < kPi);
        if (volume.everywhere || (ball && farthestIn(slab, volume.center) <= volume.radius)) {
            for (std::size_t i = first; i <= last; ++i) mark(i);
            continue;
        }
        if (beside(slab, 2)) continue;
        for (std::size_t row = first; row <= last; row += width) {
            if (beside(boxes[row], 1)) continue;
            if (rows && rows->misses((row - first) / width, volume.center, reach)) continue;
            for (std::size_t i = row; i < row + width; ++i) {
                if (beside(boxes[i], 0) || (columns && columns->misses(i - row, volume.center, reach))) continue;
                if (meets(volume, boxes[i])) mark(i);
            }
        }
    }
}

} // namespace

ivec3 LightClusters::clusterAt(vec2 uv, float viewDepthMeters) const
{
    const float depth = std::max(viewDepthMeters, 1.0e-20f);
    const float slice = std::floor(math::log2(depth / nearMeters) * float(size.z) / math::log2(farMeters / nearMeters));
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
    std::vector<LightVolume> volumes;
    for (const FrameLight& light : lights) {
        LightVolume& volume = volumes.emplace_back(volumeOf(scene.lights[std::size_t(light.light)]));
        volume.center = vec3(viewFromWorld * vec4(volume.center, 1.0f));
        volume.axis = mat3(viewFromWorld) * volume.axis;
    }
    const vec2 half = halfExtent(view);
    const Wedges columns(0, kClusterGrid.x, half.x, false);
    const Wedges rows(1, kClusterGrid.y, half.y, true);
    const bool wedged = !camera.orthographic; // boxes are exact where all rays are parallel
    parallelFor(std::size_t(kClusterGrid.z), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z)
            fillSlice(volumes, boxes, wedged ? &columns : nullptr, wedged ? &rows : nullptr, z, clusters.words);
    });
    return clusters;
}

} // namespace halflight
