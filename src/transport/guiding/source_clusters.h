#pragma once
// Secondary light sources in clusters, sampled by area.

#include "transport/guiding/patch_light.h"
#include "transport/radiosity/patch_layout.h"
#include "transport/random/alias_table.h"

#include "halflight/shading/sampling.h"

#include <array>
#include <span>
#include <vector>

namespace halflight {

/// A sampled point of a secondary source.
struct SourcePoint {
    FaceId face;
    PatchId patch = 0;
    vec2 barycentric{0.0f};
    vec3 position{0.0f};
    vec3 normal{0.0f};    ///< geometric, of the face
    float pdfArea = 0.0f; ///< per square metre; 0 = no sample
};

/// Clusters of patches (lightcuts: Walter et al. 2005, "Lightcuts: A Scalable Approach to Illumination"). A cluster is
/// a cell of a hash grid 32 texels wide. Points on it are in proportion to radiance.
class SourceClusters {
public:
    SourceClusters() = default;
    /// Clusters of the patches that were hit, by number of hits.
    SourceClusters(std::span<const PatchLight> patches, std::span<const uint32_t> timesHit, float texelMeters);
    /// Removes clusters of use 0 and, beyond a limit that follows from the map's size, those of least use per triangle;
    /// then finds the triangles of the others.
    void finish(const PatchLayout& layout, const RayTracer& tracer, std::span<const PatchLight> patches,
                std::span<const float> useOfCluster);

    /// Part of a scene triangle that lies in one patch.
    struct SourceTriangle {
        FaceId face;
        PatchId patch = 0;
        std::array<vec2, 3> corners; ///< barycentric
        vec3 origin{0.0f};
        vec3 edge1{0.0f};
        vec3 edge2{0.0f};
        vec3 normal{0.0f};    ///< of its face
        float pdfArea = 0.0f; ///< given the cluster
        [[nodiscard]] float area() const { return 0.5f * glm::length(glm::cross(edge1, edge2)); }
    };
    /// Its triangles among those of all clusters.
    struct Cluster {
        uint32_t firstTriangle = 0;
        uint32_t triangleCount = 0;
    };
    /// A chart patch as a member of a cluster.
    struct Member {
        uint32_t cluster = ~0u;
        float pdfArea = 0.0f; ///< given the cluster; 0 = not sampled
    };
    template<typename Archive> void archive(Archive& a) { a(clusters_, triangles_, bins_, members_); }
    [[nodiscard]] bool empty() const { return triangles_.empty(); }
    [[nodiscard]] std::size_t size() const { return clusters_.size(); }
    [[nodiscard]] std::span<const Cluster> clusters() const { return clusters_; }
    [[nodiscard]] std::span<const SourceTriangle> triangles() const { return triangles_; } ///< cluster by cluster
    [[nodiscard]] std::span<const AliasBin> bins() const { return bins_; }                 ///< of the triangles
    [[nodiscard]] std::span<const Member> members() const { return members_; }             ///< by chart patch
    /// ~0 = none.
    [[nodiscard]] uint32_t clusterOf(PatchId patch) const
    {
        return patch < members_.size() ? members_[patch].cluster : ~0u;
    }
    /// Whether points of a patch are sampled.
    [[nodiscard]] bool contains(PatchId patch) const
    {
        return patch < members_.size() && members_[patch].pdfArea > 0.0f;
    }
    /// Density on a patch given its cluster, per square metre; 0 for patches that are not sampled.
    [[nodiscard]] float pdfArea(PatchId patch) const { return members_[patch].pdfArea; }

    /// A point of a cluster that was chosen with `probability`; none of a cluster that was removed.
    [[nodiscard]] SourcePoint choosePoint(uint32_t number, float probability, vec2 u) const
    {
        const Cluster& cluster = clusters_[number];
        if (cluster.triangleCount == 0) return {};
        const float at = u.x * float(cluster.triangleCount);
        const uint32_t bin = std::min(uint32_t(at), cluster.triangleCount - 1);
        u.x = at - float(bin);
        const uint32_t first = cluster.firstTriangle + bin;
        const SourceTriangle& t = triangles_[first + bins_[first].select(u.x)];
        const vec2 on = shading::sampleTriangle(u);
        const vec2 barycentric =
            t.corners[0] + on.x * (t.corners[1] - t.corners[0]) + on.y * (t.corners[2] - t.corners[0]);
        return {t.face,      t.patch,
                barycentric, t.origin + on.x * t.edge1 + on.y * t.edge2,
                t.normal,    probability * t.pdfArea};
    }

private:
    template<typename Body> void forTriangles(const PatchLayout& layout, const RayTracer& tracer, uint32_t begin,
                                              uint32_t end, const Body& body) const;
    void remove(std::span<const float> useOfCluster, std::span<const uint32_t> triangleCounts);
    void addTriangles(const PatchLayout& layout, const RayTracer& tracer, std::span<const PatchLight> patches);
    void setDensities(const Cluster& cluster, std::span<const PatchLight> patches);

    std::vector<Cluster> clusters_;
    std::vector<SourceTriangle> triangles_;
    std::vector<AliasBin> bins_;
    std::vector<Member> members_;
};

} // namespace halflight
