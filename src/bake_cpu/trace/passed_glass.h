#pragma once
// Colour of the glass along one ray.

#include "halflight/base/math.h"
#include "halflight/shading/coverage.h"

#include <array>
#include <cstdint>

namespace halflight::embree {

/// Faces of glass that a ray passes, in any order. Embree offers candidates behind the final hit too, so that distances
/// are kept.
class PassedGlass {
public:
    struct Face {
        uint32_t triangle;
        float distance;
        vec3 passed;  ///< share of light, by colour
        vec3 leaving; ///< attenuation in 1/m of the volume that the ray leaves; below 0 where it enters
    };

    /// Whether the ray has met the triangle: Embree may report one that RTC_BUILD_QUALITY_HIGH splits more than once. A
    /// ray through the edge of two triangles may meet both, which count once.
    [[nodiscard]] bool knows(const Face& face) const
    {
        for (int i = 0; i < count_; ++i) {
            const Face& other = faces_[std::size_t(i)];
            if (other.triangle == face.triangle) return true;
            if (shading::isSamePlace(other.distance, face.distance) && other.leaving == face.leaving &&
                other.passed == face.passed)
                return true;
        }
        return false;
    }
    [[nodiscard]] bool full() const { return count_ == int(faces_.size()); }
    void add(const Face& face) { faces_[std::size_t(count_++)] = face; }

    /// What is left of light from `end` to the ray's origin, by the faces before `end`.
    [[nodiscard]] vec3 transmittance(float end) const
    {
        vec3 passed(1.0f);
        vec3 way(0.0f);
        vec3 inside(0.0f);
        for (int i = 0; i < count_; ++i) {
            const Face& face = faces_[std::size_t(i)];
            if (face.distance >= end) continue;
            passed *= face.passed;
            way += face.distance * face.leaving;
            inside -= face.leaving;
        }
        return shading::glassLeaves(passed, way, inside, end);
    }

private:
    static constexpr std::size_t kMost = 32; ///< further faces pass by chance, without a colour
    int count_ = 0;
    std::array<Face, kMost> faces_;
};

} // namespace halflight::embree
