#pragma once
// Whole paths of light to many points at once, on a device.

#include "halflight/base/math.h"
#include "halflight/base/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace halflight {

/// Paths with the random numbers, and but for rounding the light, of PathTracer::incoming(). Before each path goes on
/// from its start, one sample of emitters and one of the sky's bright part are taken there, as DirectLight takes them.
/// Light is estimated as one: there are no components.
class DevicePaths {
public:
    virtual ~DevicePaths() = default;

    /// Where paths begin, in world space. Normals are those of SurfacePoint, or zero at points in space.
    struct Point {
        vec3 position{0.0f};
        vec3 normal{0.0f};
        vec3 geometricNormal{0.0f};
    };
    /// What paths are traced for. Path n begins at point n, modulo their number.
    struct Item {
        uint32_t id = 0;         ///< of its random numbers: Sampler(Batch::seed, id, n)
        uint32_t firstPoint = 0; ///< index into a list of points
        uint32_t pointCount = 1; ///< 1 … kMostPointsOfItem
    };
    /// Paths `firstPath` … `firstPath` + pathsOfItem - 1 of all items.
    struct Batch {
        std::span<const Point> points; ///< kMostPointsOfItem for each item at most
        std::span<const Item> items;   ///< kMostPaths / pathsOfItem at most, and kMostItems
        uint32_t seed = 1;
        uint32_t firstPath = 0;
        uint32_t pathsOfItem = 1; ///< 1 … kMostPaths
    };
    /// What a path's first ray brings. From a surface the ray's direction is cosine-distributed (gatherDirection()),
    /// from a point in space it is uniform (shading::sampleSphere()).
    struct Arrival {
        vec3 radiance{0.0f};  ///< nits, without the sky's bright part where the ray itself leaves the scene
        vec3 direction{0.0f}; ///< of the ray
        uint32_t rays = 0;    ///< of the path and of the samples at its start
        uint32_t back = 0;    ///< 1: the ray hits a hidden back
    };
    /// What the samples at a path's start bring, and their directions. Lux on a surface; in space radiance over its
    /// density per steradian.
    struct Emission {
        vec3 ofEmitter{0.0f};
        vec3 toEmitter{0.0f};
        vec3 ofSky{0.0f};
        vec3 toSky{0.0f};
    };
    /// Of path n of item i at [i * pathsOfItem + n - firstPath]. `emissions` is empty where the scene has neither
    /// emitters nor a bright part of the sky (SceneLight::samplesEmission()).
    using Use = std::function<void(std::span<const Arrival> arrivals, std::span<const Emission> emissions)>;

    static constexpr uint32_t kMostPaths = 1u << 18; ///< of one call: 25 MiB with emissions
    static constexpr uint32_t kMostItems = 1u << 14;
    static constexpr uint32_t kMostPointsOfItem = 16;
    /// How many items a call takes that have so many paths each. Callers give a call the same items each time: on some
    /// devices a ray's neighbours decide what it hits at an edge.
    static std::size_t itemsOfCall(int paths) { return std::clamp(kMostPaths / uint32_t(paths), 1u, kMostItems); }

    /// Traces a batch and calls use(), unless there is an error. Any thread may call it; a few calls run at one time.
    virtual Status trace(const Batch& batch, const Use& use) const = 0;

    /// Traces paths 0 … `paths` - 1 of all items of a call, in several where one item has more than a call takes. Calls
    /// take(index of the item, arrival, emission) for each, in the order of items and paths.
    template<typename Take> Status traceAll(std::span<const Point> points, std::span<const Item> items, uint32_t seed,
                                            uint32_t paths, const Take& take) const
    {
        for (uint32_t first = 0; first < paths; first += kMostPaths) {
            const uint32_t count = std::min(paths - first, kMostPaths);
            const auto use = [&](std::span<const Arrival> arrivals, std::span<const Emission> emissions) {
                for (std::size_t i = 0; i < arrivals.size(); ++i)
                    take(i / count, arrivals[i], emissions.empty() ? Emission() : emissions[i]);
            };
            if (Status s = trace({points, items, seed, first, count}, use); !s) return s;
        }
        return {};
    }
};

} // namespace halflight
