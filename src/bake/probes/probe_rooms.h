#pragma once
// Where light probes are needed: places in the air beside surfaces, and the cells of probes that do not see them.

#include "bake/probes/probe_tree.h"

#include <functional>

namespace halflight {

/// A place in the air beside a surface.
struct Place {
    vec3 position{0.0f};
    float roomMeters = kInfinity; ///< between the surfaces on both sides of it along an axis, if there are two
};

/// Places beside surfaces, found by rays along the axes through a box: `reachMeters` off, or halfway between two
/// surfaces that are nearer to one another. Gaps narrower than one reach have none. Columns of rays are two reaches
/// apart, or as far as keeps them few; so no room wider than that is missed, however large the world is. Some places
/// are inside geometry.
Result<std::vector<Place>> placesBesideSurfaces(const Bounds& box, float reachMeters, const Integrator& integrator);

/// Whether a place is in the dark and at the rim of the scene, as behind the wall of a lit room under no sky: its rays
/// end in nothing, and nobody sees objects there. A dark place in a room is not. `dark`: darkIrradiance().
bool isUnlit(const Place& place, const SphericalHarmonicsL2& radiance, float dark);

/// Places of check probes, spread over a list: one to 32 probes, up to 250.
std::vector<Place> checkPlaces(const std::vector<Place>& places, std::size_t probeCount);

/// A cell of probes, and the places in it.
struct RoomCell {
    ProbeTree::Cell cell;
    std::vector<uint32_t> places;
};

/// Finds cells whose corners do not say what light is in them.
class RoomSearch {
public:
    /// `reachMeters`: as above.
    RoomSearch(ProbeTree& tree, std::vector<Place> places, float reachMeters, Integrator& integrator)
        : tree_(tree), places_(std::move(places)), known_(places_.size(), kUnknown), reach_(reachMeters),
          integrator_(integrator)
    {}

    [[nodiscard]] const Place& at(uint32_t place) const { return places_[place]; }
    /// The grid's cells with their places.
    [[nodiscard]] std::vector<RoomCell> gridCells() const;
    /// The halves of a cell with theirs.
    [[nodiscard]] std::vector<RoomCell> halvesOf(const RoomCell& room) const;

    struct Verdict {
        bool halve = false;
        float error = 0.0f;             ///< 0…1: how urgent that is
        std::optional<uint32_t> unseen; ///< a place that no corner sees, or that is beyond all and lit differently
    };
    /// Of each cell. A cell is to be halved
    /// - if no corner or a single one sees some place in it, or light differs between the corners that see it, and in
    ///   rooms is not what they interpolate;
    /// - if it is longer than twice the room around some place, or
    /// - surfaces hide places from some corners, and light differs between the corners, or between them and the place
    ///   that most of them do not see; both not for cells that are shorter than four times kFinestMeters.
    /// For light alone, halves are no shorter than kRoomShare of the smallest room in them.
    /// `probes`: all so far.
    Result<std::vector<Verdict>> judge(std::span<const RoomCell> cells, std::span<const Probe> probes,
                                       const Progress& progress);

private:
    enum : uint8_t { kUnknown, kOutside, kInside };
    struct Sight {
        std::vector<uint32_t> unseen;     ///< places that no corner sees
        std::optional<uint32_t> hidden;   ///< the place that the fewest corners see, if not all do
        std::vector<uint32_t> corners;    ///< valid ones, as probes
        float evenness = 1.0f;            ///< least over largest light of the corners that see a place
        std::optional<uint32_t> steepest; ///< the place with that evenness
        float interpolated = 0.0f;        ///< light (lux) that the corners say is there
        bool isLonely = false;            ///< a single corner sees some place, which says nothing of how light changes
    };
    [[nodiscard]] vec3 place(uint32_t i) const { return places_[i].position; }
    [[nodiscard]] Result<std::vector<Sight>> sightOf(std::span<const RoomCell> cells, std::span<const Probe> probes,
                                                     float dark) const;
    Status findOutside(std::vector<uint32_t> places, float dark, const Progress& progress);
    [[nodiscard]] Result<std::vector<uint8_t>> clearOf(std::span<const uint32_t> places) const;
    [[nodiscard]] float roomIn(const RoomCell& cell) const;
    [[nodiscard]] static float finestIn(float room);
    [[nodiscard]] float beyondMeters(const ProbeTree::Cell& cell, uint32_t i) const;
    Status checkSteep(std::span<const RoomCell> cells, std::span<const Sight> sights, float dark,
                      std::vector<Verdict>& verdicts, const Progress& progress) const;
    Status compareLight(std::span<const RoomCell> cells, std::span<const Sight> sights, std::span<const Probe> probes,
                        float dark, std::vector<Verdict>& verdicts, const Progress& progress) const;
    Status trace(std::span<const uint32_t> places, int paths, std::vector<ProbeEstimate>& out,
                 const Progress& progress) const;

    ProbeTree& tree_;
    std::vector<Place> places_;
    std::vector<uint8_t> known_; ///< by place: kOutside or kInside geometry
    float reach_;
    Integrator& integrator_;
};

} // namespace halflight
