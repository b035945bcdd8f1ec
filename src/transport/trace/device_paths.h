#pragma once
// Whole paths of light to many points at once, on a device.

#include "halflight/base/function_ref.h"
#include "halflight/base/math.h"
#include "halflight/base/result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace halflight {

/// Paths with the random numbers, and but for rounding the light, of PathTracer::incoming(). Before each path goes on
/// from its start, one sample of emitters and one of the sky's bright part are taken there, as DirectLight takes them.
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
        std::span<const Item> items;   ///< mostPaths() / pathsOfItem at most, and kMostItems
        uint32_t seed = 1;
        uint32_t firstPath = 0;
        uint32_t pathsOfItem = 1; ///< 1 … mostPaths()
        bool byComponent = false; ///< the light of components is asked for; as in PathTracer they have no roulette
    };
    /// What a path's first ray brings. From a surface the ray's direction is cosine-distributed (gatherDirection()),
    /// from a point in space it is uniform (shading::sampleSphere()).
    struct Arrival {
        vec3 radiance{0.0f};           ///< nits, without the sky's bright part where the ray itself leaves the scene
        vec3 direction{0.0f};          ///< of the ray
        uint32_t rays = 0;             ///< of the path and of the samples at its start
        uint16_t back = 0;             ///< 1: the ray hits a hidden back
        uint16_t emitterComponent = 0; ///< of Emission::ofEmitter
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
    /// emitters nor a bright part of the sky (SceneLight::samplesEmission()). `components`: radiance by path and
    /// component, of which Arrival::radiance is the sum; empty unless it is asked for.
    struct Light {
        std::span<const Arrival> arrivals;
        std::span<const Emission> emissions;
        std::span<const vec3> components;
    };
    using Use = FunctionRef<void(const Light& light)>;

    static constexpr uint32_t kMostPaths = 1u << 18; ///< of one call: 25 MiB with emissions
    /// The same where so many components are asked for: at most 11 MiB of theirs.
    static constexpr uint32_t mostPaths(int components) { return kMostPaths / uint32_t(1 + components / 4); }
    static constexpr uint32_t kMostItems = 1u << 14;
    static constexpr uint32_t kMostPointsOfItem = 16;
    /// How many items a call takes that have so many paths each. Callers give a call the same items each time: on some
    /// devices a ray's neighbours decide what it hits at an edge.
    static std::size_t itemsOfCall(int paths, int components = 0)
    {
        return std::clamp(mostPaths(components) / uint32_t(paths), 1u, kMostItems);
    }

    /// Traces a batch and calls use(), unless there is an error. Any thread may call it; a few calls run at one time.
    virtual Status trace(const Batch& batch, Use use) const = 0;

    /// Traces paths 0 … `paths` - 1 of all items of a call, in several where one item has more than a call takes. Calls
    /// take(index of the item, arrival, emission, radiance of components) for each, in the order of items and paths.
    /// `components`: their number, or 0.
    template<typename Take> Status traceAll(std::span<const Point> points, std::span<const Item> items, uint32_t seed,
                                            uint32_t paths, int components, const Take& take) const
    {
        const uint32_t most = mostPaths(components);
        const auto row = std::size_t(components);
        for (uint32_t first = 0; first < paths; first += most) {
            const uint32_t count = std::min(paths - first, most);
            const auto use = [&](const Light& light) {
                for (std::size_t i = 0; i < light.arrivals.size(); ++i)
                    take(i / count, light.arrivals[i], light.emissions.empty() ? Emission() : light.emissions[i],
                         light.components.subspan(i * row, row));
            };
            if (Status s = trace({points, items, seed, first, count, row > 0}, use); !s) return s;
        }
        return {};
    }
};

} // namespace halflight
