#pragma once
// What a bake saw of the scene, in numbers that the baked file keeps: whoever reads the file can tell what was changed
// since. Tools quantize and re-order vertices and compress textures again, so these are means and bounds that are
// compared within a tolerance, and no hashes.

#include "scene/document/document.h"

#include <array>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

/// Those of the root extension's members that hold what a bake found, as "probes/sight": what a reader looks for.
Json membersOfBake(const Json& root);
/// Those of them that a file had (`atBake` of its root) and has no more.
std::vector<std::string> lostMembers(const Json& root);

/// The surface of a node's static objects, all instances together. Means are over its area.
struct SurfaceAtBake {
    vec3 low{0.0f}; ///< bounds and centroid: scene space, metres
    vec3 high{0.0f};
    vec3 centroid{0.0f};
    vec3 spread{0.0f}; ///< standard deviation of its points along each axis, metres
    float area = 0.0f; ///< m2
    /// Shares of the area: casts shadows, receives shadows, is double-sided, is unlit.
    std::array<float, 4> switches{};
    /// Of the materials with their textures and vertex colours. False: not known, as textures were not decoded.
    bool hasColors = false;
    vec3 color{0.0f};    ///< base colour to the power 1/2.2
    vec3 emission{0.0f}; ///< cd/m2 to the power 1/2.2
    float opacity = 1.0f;
    float metallic = 0.0f;

    /// `atBake` of HALFLIGHT_node.
    [[nodiscard]] Json json() const;
    /// Nothing where a member is missing or no number. `shift` takes positions of the file to the scene's.
    static std::optional<SurfaceAtBake> from(const Json& json, const glm::dvec3& shift);
    [[nodiscard]] bool differsFrom(const SurfaceAtBake& other) const;
};

class AtBake {
public:
    /// `scene` outlives this.
    explicit AtBake(const Scene& scene);

    /// Nothing without a static object.
    [[nodiscard]] std::optional<SurfaceAtBake> ofObjects(std::span<const Object* const> objects) const;
    /// `atBake` of the root extension without the sky. `lightmapped`: nodes with lightmap texels.
    [[nodiscard]] Json sceneJson(std::size_t lightmapped) const;

private:
    struct Sums;
    struct Reader;
    struct Look;
    void add(const Object& object, const MeshPart& part, Sums& sums) const;
    void addTriangle(const MeshPart& part, const Look& look, std::size_t triangle, const Object& object, int samples,
                     Sums& sums) const;
    [[nodiscard]] Reader readerOf(const TextureRef& ref, const MeshPart& part) const;
    [[nodiscard]] Look lookOf(const MeshPart& part) const;

    const Scene& scene_;
    bool hasColors_ = true;
    std::map<int, Image<vec4>> small_; ///< by texture
};

/// What a bake saw of a light beyond changesSinceBake(): its size, cone, range and shadow switch.
bool shapeChangedSinceBake(const Light& light);

} // namespace halflight
