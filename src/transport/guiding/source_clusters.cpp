#include "transport/guiding/source_clusters.h"

#include "transport/guiding/receiver_grid.h"

#include "halflight/base/atomic_ref.h"
#include "halflight/base/memory.h"
#include "halflight/base/parallel.h"
#include "halflight/base/polygon.h"

#include <algorithm>

namespace halflight {
namespace {

/// Width of a cluster.
constexpr float kClusterTexels = 32.0f;
/// In a cluster where more than this share of hits are the only ones of their patch, rays missed many other patches.
constexpr float kManyOnce = 0.2f;
/// Of these, patches with at least this share of the mean radiance are members.
constexpr float kAsBright = 0.5f;
/// Most source triangles, of 92 bytes each: 96 MB.
constexpr std::size_t kMostTriangles = std::size_t(1) << 20;
constexpr std::size_t kTrianglesAtOnce = 256; // that a thread takes, of those that rays can hit

/// Calls body(patch, x, y) for each front patch that the bounds of a triangle overlap.
template<typename Body> void forPatches(const PatchLayout::Surface& s, const Body& body)
{
    const vec2 low = s.origin + glm::min(vec2(0.0f), glm::min(s.edgeU, s.edgeV));
    const vec2 high = s.origin + glm::max(vec2(0.0f), glm::max(s.edgeU, s.edgeV));
    const ivec2 last(int(s.width) - 1, int(s.height) - 1);
    const ivec2 from = glm::clamp(ivec2(low), ivec2(0), last);
    const ivec2 to = glm::clamp(ivec2(high), ivec2(0), last);
    for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) body(s.firstPatch + uint32_t(y) * s.width + uint32_t(x), x, y);
    }
}

/// Part of a triangle in one of its patches, in barycentric weights. Parts beyond the rectangle of patches belong to
/// the patches at its border, as in PatchLayout::patchAt().
Polygon partIn(const PatchLayout::Surface& s, int x, int y)
{
    Polygon part;
    part.points = {{{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}}};
    part.count = 3;
    const auto between = [&](vec2 along, float origin, int i, int count) {
        if (i > 0) part = clip(part, along, float(i) - origin);
        if (i + 1 < count) part = clip(part, -along, origin - float(i + 1));
    };
    between({s.edgeU.y, s.edgeV.y}, s.origin.y, y, s.height);
    between({s.edgeU.x, s.edgeV.x}, s.origin.x, x, s.width);
    return part;
}

} // namespace

/// Members of a cluster are the patches that were hit. Where many were hit only once, there are more that no ray
/// happened to hit (Good 1953, "The Population Frequencies of Species"); the bright ones are members too.
SourceClusters::SourceClusters(std::span<const PatchLight> patches, std::span<const uint32_t> timesHit,
                               float texelMeters)
    : members_(patches.size())
{
    const HashGrid grid(kClusterTexels * texelMeters);
    std::vector<uint64_t> keys(patches.size(), HashGrid::kNone);
    for (std::size_t i = 0; i < patches.size(); ++i) {
        if (timesHit[i] > 0) keys[i] = grid.key(patches[i].position, patches[i].axis);
    }
    std::vector<uint32_t> clusterOfHit;
    const std::vector<uint64_t> clusterKeys = HashGrid::numberKeys(keys, clusterOfHit);
    release(keys);
    struct Hits {
        float patches = 0.0f;
        float once = 0.0f; ///< patches hit once
        float times = 0.0f;
        float radiance = 0.0f; ///< sum over the patches
    };
    std::vector<Hits> hits(clusterKeys.size());
    for (std::size_t i = 0; i < patches.size(); ++i) {
        if (timesHit[i] == 0) continue;
        Hits& h = hits[clusterOfHit[i]];
        ++h.patches;
        h.once += timesHit[i] == 1 ? 1.0f : 0.0f;
        h.times += float(timesHit[i]);
        h.radiance += patches[i].radiance;
    }
    clusters_.resize(clusterKeys.size());
    for (std::size_t i = 0; i < patches.size(); ++i) {
        const PatchLight& patch = patches[i];
        members_[i].cluster = clusterOfHit[i];
        if (timesHit[i] > 0 || patch.axis == PatchLight::kNoAxis || !(patch.radiance < kInfinity)) continue;
        const uint64_t key = grid.key(patch.position, patch.axis);
        const auto found = std::lower_bound(clusterKeys.begin(), clusterKeys.end(), key);
        if (found == clusterKeys.end() || *found != key) continue;
        const Hits& h = hits[std::size_t(found - clusterKeys.begin())];
        if (h.once < kManyOnce * h.times || patch.radiance * h.patches < kAsBright * h.radiance) continue;
        members_[i].cluster = uint32_t(found - clusterKeys.begin());
    }
}

void SourceClusters::finish(const PatchLayout& layout, const RayTracer& tracer, std::span<const PatchLight> patches,
                            std::span<const float> useOfCluster)
{
    for (Member& m : members_) {
        if (m.cluster != ~0u && useOfCluster[m.cluster] <= 0.0f) m.cluster = ~0u;
    }
    std::vector<uint32_t> counts(clusters_.size());
    parallelFor(tracer.hitTriangleCount(), kTrianglesAtOnce, [&](std::size_t begin, std::size_t end) {
        forTriangles(layout, tracer, uint32_t(begin), uint32_t(end), [&](const SourceTriangle& t) {
            AtomicRef<uint32_t>(counts[clusterOf(t.patch)]).fetch_add(1, std::memory_order_relaxed);
        });
    });
    remove(useOfCluster, counts);
    addTriangles(layout, tracer, patches);
}

/// Calls body(triangle) for each part of a triangle that lies in a member patch, of hit indices `begin` to `end`.
template<typename Body> void SourceClusters::forTriangles(const PatchLayout& layout, const RayTracer& tracer,
                                                          uint32_t begin, uint32_t end, const Body& body) const
{
    const BakeGeometry& geometry = tracer.geometry();
    for (uint32_t index = begin; index < end; ++index) {
        const FaceId front{index, 0};
        if (!layout.hasPatches(front)) continue;
        const uint32_t triangle = tracer.triangleAt(index);
        // Rays do not hit objects that cast no shadow.
        if (!geometry.partOf(triangle).castShadows) continue;
        const std::array<vec3, 3> corners = geometry.cornersOf(triangle);
        const vec3 origin = corners[0];
        const vec3 edge1 = corners[1] - origin;
        const vec3 edge2 = corners[2] - origin;
        const auto along = [&](vec2 b) { return b.x * edge1 + b.y * edge2; };
        SourceTriangle source;
        forPatches(layout.surface(front), [&](PatchId patch, int x, int y) {
            for (const bool back : {false, true}) {
                source.patch = back ? layout.backOf(patch) : patch;
                if (clusterOf(source.patch) == ~0u) continue;
                source.face = {index, back ? 1u : 0u};
                source.normal = geometry.geometricNormal(triangle) * (back ? -1.0f : 1.0f);
                const Polygon polygon = partIn(layout.surface(front), x, y);
                for (std::size_t i = 1; i + 1 < std::size_t(polygon.count); ++i) {
                    source.corners = {polygon.points[0], polygon.points[i], polygon.points[i + 1]};
                    source.origin = origin + along(source.corners[0]);
                    source.edge1 = along(source.corners[1] - source.corners[0]);
                    source.edge2 = along(source.corners[2] - source.corners[0]);
                    if (source.area() > 0.0f) body(source);
                }
            }
        });
    }
}

/// Keeps clusters in descending order of use per triangle, up to the limit.
void SourceClusters::remove(std::span<const float> useOfCluster, std::span<const uint32_t> triangleCounts)
{
    std::vector<uint32_t> order;
    for (uint32_t c = 0; c < clusters_.size(); ++c) {
        if (triangleCounts[c] > 0) order.push_back(c);
    }
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        const float left = useOfCluster[a] * float(triangleCounts[b]);
        const float right = useOfCluster[b] * float(triangleCounts[a]);
        return left != right ? left > right : a < b;
    });
    std::size_t count = 0;
    for (const uint32_t c : order) {
        if (count + triangleCounts[c] > kMostTriangles) break;
        clusters_[c] = {uint32_t(count), triangleCounts[c]};
        count += triangleCounts[c];
    }
    for (Member& m : members_) {
        if (m.cluster != ~0u && clusters_[m.cluster].triangleCount == 0) m.cluster = ~0u;
    }
    triangles_.resize(count);
}

void SourceClusters::addTriangles(const PatchLayout& layout, const RayTracer& tracer,
                                  std::span<const PatchLight> patches)
{
    const std::size_t hits = tracer.hitTriangleCount();
    std::vector<std::vector<SourceTriangle>> lists((hits + kTrianglesAtOnce - 1) / kTrianglesAtOnce);
    parallelFor(lists.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t l = begin; l < end; ++l) {
            const std::size_t first = l * kTrianglesAtOnce;
            forTriangles(layout, tracer, uint32_t(first), uint32_t(std::min(first + kTrianglesAtOnce, hits)),
                         [&](const SourceTriangle& t) { lists[l].push_back(t); });
        }
    });
    std::vector<uint32_t> found(clusters_.size());
    for (const std::vector<SourceTriangle>& list : lists) {
        for (const SourceTriangle& t : list) {
            const uint32_t cluster = clusterOf(t.patch);
            triangles_[clusters_[cluster].firstTriangle + found[cluster]++] = t;
        }
    }
    bins_.resize(triangles_.size());
    parallelFor(clusters_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) setDensities(clusters_[c], patches);
    });
}

/// Densities and bins of a cluster's triangles, in proportion to area and radiance.
void SourceClusters::setDensities(const Cluster& cluster, std::span<const PatchLight> patches)
{
    const auto triangles = std::span(triangles_).subspan(cluster.firstTriangle, cluster.triangleCount);
    std::vector<double> powers(triangles.size());
    double power = 0.0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        powers[i] = double(triangles[i].area()) * double(patches[triangles[i].patch].radiance);
        power += powers[i];
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        powers[i] /= power;
        const float radiance = patches[triangles[i].patch].radiance;
        triangles[i].pdfArea = members_[triangles[i].patch].pdfArea = float(double(radiance) / power);
    }
    fillAliasTable(powers, std::span(bins_).subspan(cluster.firstTriangle, cluster.triangleCount));
}

} // namespace halflight
