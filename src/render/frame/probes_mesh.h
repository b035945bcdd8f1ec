#pragma once
// Point location in the tetrahedra between probes, and the nearest point of their hull.

#include "halflight/render/probes.h"
#include "halflight/scene/probe_cells.h"

#include <glm/gtc/type_precision.hpp>

#include <array>
#include <span>
#include <utility>
#include <vector>

namespace halflight {

/// Triangles of a hull in a tree of boxes, for the nearest point on them.
class HullFaces {
public:
    struct Face {
        std::array<uint32_t, 3> vertex{};
    };
    struct Nearest {
        uint32_t face = 0;
        std::array<double, 3> weights{};
    };

    void build(std::vector<Face> faces, std::span<const glm::dvec3> vertices);
    [[nodiscard]] Nearest nearest(glm::dvec3 point, std::span<const glm::dvec3> vertices) const;
    [[nodiscard]] const Face& face(uint32_t i) const { return faces_[i]; }

private:
    struct Node {
        glm::dvec3 low{0.0};
        glm::dvec3 high{0.0};
        uint32_t begin = 0; ///< a leaf's faces
        uint32_t end = 0;
        uint32_t right = 0; ///< second child, the first is the next node; 0 in a leaf
    };
    void split(std::size_t node, std::span<const glm::dvec3> vertices);

    std::vector<Face> faces_;
    std::vector<Node> nodes_;
};

/// ProbeSight, of the probes in use.
class ProbeSightMaps {
public:
    ProbeSightMaps() = default;
    /// `sources`: the index in the scene of each probe in use.
    ProbeSightMaps(const ProbeSight& sight, std::span<const uint32_t> sources);

    /// Weight of a probe in use at a point `offset` metres from it, along the world's axes: 1 in sight, nearly 0 behind
    /// a surface. Continuous.
    [[nodiscard]] float weight(uint32_t place, vec3 offset) const;

private:
    struct Map {
        float rangeMeters = 0.0f;
        std::size_t first = 0; ///< of its moments
    };
    int size_ = 0;
    std::vector<Map> maps_;     ///< by probe in use; empty without any map
    std::vector<vec2> moments_; ///< nearness times range, and its variance
};

class ProbeMesh {
public:
    explicit ProbeMesh(const BakedScene& baked);

    [[nodiscard]] bool empty() const { return probes_.empty(); }
    /// Weights of the probes in use, as places in probes().
    [[nodiscard]] ProbeWeights weights(vec3 position) const;
    [[nodiscard]] const std::vector<Probe>& probes() const { return probes_; }
    [[nodiscard]] const std::vector<uint32_t>& sources() const { return sources_; } ///< their indices in the scene
    [[nodiscard]] std::size_t tetrahedronCount() const { return mesh_.cells.size(); }
    [[nodiscard]] vec3 spacingMeters() const { return mesh_.spacingMeters; }
    [[nodiscard]] const ProbeSample& sky() const { return sky_; }

private:
    struct Where {
        uint32_t cell = 0;
        bool outside = false;
        std::array<double, 4> weights{};
    };

    using Shares = std::array<std::pair<uint32_t, double>, 4>; ///< of places

    void buildHull();
    void buildStarts();
    void weighBySight(Shares& shares) const;
    [[nodiscard]] Where walk(uint32_t start, glm::dvec3 point) const;
    [[nodiscard]] std::array<double, 4> weightsIn(const Tetrahedron& cell, glm::dvec3 point) const;
    [[nodiscard]] std::size_t startCellOf(glm::dvec3 point) const;

    /// Copies of a probe along flat axes follow the probes, as many in each layer.
    [[nodiscard]] uint32_t placeOf(uint32_t vertex) const { return uint32_t(vertex % mesh_.probeCount); }

    std::vector<Probe> probes_;
    std::vector<uint32_t> sources_;
    ProbeSample sky_;
    ProbeCells mesh_;
    HullFaces hull_;
    ProbeSightMaps sight_;

    // Where a walk begins, by the point's place in a coarse grid.
    glm::dvec3 low_{0.0};
    glm::dvec3 high_{0.0};
    ivec3 startSize_{1};
    std::vector<uint32_t> starts_;
};

} // namespace halflight
