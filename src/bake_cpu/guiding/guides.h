#pragma once
// The brightest cells of the radiance cache, sampled as light sources.

#include "bake_cpu/sample/sampler.h"
#include "bake_cpu/trace/ray_tracer.h"

#include "halflight/base/math.h"
#include "halflight/shading/sampling.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace halflight {

class RadianceCache;

/// What bright cells are chosen by, of one cell of the cache.
struct CellLight {
    static constexpr uint8_t kNowhere = 255;
    vec3 position{0.0f};          ///< of some point in it
    uint8_t direction = kNowhere; ///< of the six of the axes, the one it faces
    bool receives = false;        ///< texels gather there
    float radiance = 0.0f;        ///< luminance of what it reflects, in nits
    float illuminance = 0.0f;     ///< what rays bring it, in lux: lights are sampled apart
    float rays = 0.0f;            ///< that were gathered for it
};

/// Where the sun or a lamp close by lights a small part of what is around, few of the rays that a texel spreads over
/// its hemisphere meet it, and these bring most of the noise. So the gather aims samples at such cells too, weighted
/// against the rays that meet them as emitters' samples are (Veach and Guibas 1995). What is seen from where is known
/// from the rays that filled the cache (Jensen 1995, "Importance Driven Path Tracing using the Photon Map"): receivers
/// that lie together share a guide, a list of patches of bright cells with the share of light that came from each. The
/// fewer of their rays met any, the farther around they ask; and all are told of what makes much noise and only others
/// around have met.
/// What a guide does not know of is left to the rays.
class BrightCells {
public:
    /// Tells body(receiving cell, cell) of rays that met cells.
    using Sightings = std::function<void(const std::function<void(uint32_t, uint32_t)>& body)>;

    BrightCells() = default;
    /// `cache` has its surfaces and cells; `cells`: its squares. Of what lies within some texels' width, given in
    /// metres, cells are put together. `texels`: of the lightmap, by which memory is held down.
    BrightCells(const RadianceCache& cache, const RayTracer& tracer, std::span<const CellLight> cells,
                float texelMeters, std::size_t texels, const Sightings& sightings);

    [[nodiscard]] bool empty() const { return pieces_.empty(); }
    [[nodiscard]] bool contains(uint32_t cell) const { return cell < members_.size() && members_[cell].pdfArea > 0.0f; }

    static constexpr float kFarShare = 0.25f;
    /// Patches that receivers know of, each with a probability.
    struct List {
        uint32_t first = 0;
        uint32_t count = 0;
    };
    /// What receivers know.
    struct Guide {
        List own;
        List far;           ///< of receivers farther around: what is so small that few of their own rays meet it
        float noise = 0.0f; ///< mean square of what a ray brings of the guide's light, over the square of all light
        float share = 0.0f; ///< of the rays that meet what the guide names, weighted by brightness

        /// Of the samples, those that look for what the far list names.
        [[nodiscard]] float farShare() const { return far.count == 0 ? 0.0f : own.count == 0 ? 1.0f : kFarShare; }
    };
    /// Of a cell that receives.
    [[nodiscard]] Guide guide(uint32_t cell) const
    {
        return cell < guideOfCell_.size() && guideOfCell_[cell] != ~0u ? guides_[guideOfCell_[cell]] : Guide{};
    }

    /// A sample, step by step: what each step needs to know is on its way through memory while others take the one
    /// before.
    struct Choice {
        static constexpr uint32_t kNone = ~0u;
        uint32_t number = kNone; ///< of a patch, then a column, then a piece of surface
        float probability = 0.0f;
        vec2 u{0.0f};
    };
    [[nodiscard]] Choice choosePatch(const Guide& guide, vec2 u) const;
    void chooseColumn(Choice& choice) const
    {
        const Patch& patch = patches_[choice.number];
        choice.number = Choice::kNone;
        if (patch.pieceCount == 0) return;
        const float at = choice.u.x * float(patch.pieceCount);
        const uint32_t column = std::min(uint32_t(at), patch.pieceCount - 1);
        choice.number = patch.firstPiece + column;
        choice.u.x = at - float(column);
        __builtin_prefetch(&columns_[choice.number]);
    }
    void choosePiece(Choice& choice) const
    {
        const Column& column = columns_[choice.number];
        const bool own = choice.u.x < column.share;
        const float u = own ? choice.u.x / column.share : (choice.u.x - column.share) / (1.0f - column.share);
        choice.u.x = std::min(u, 0x1.fffffep-1f);
        choice.number += own ? 0 : column.other;
        const char* piece = reinterpret_cast<const char*>(&pieces_[choice.number]);
        __builtin_prefetch(piece);
        __builtin_prefetch(piece + sizeof(Piece) - 1);
    }
    struct Place {
        uint32_t record = 0; ///< as RadianceCache::recordOf()
        uint32_t cell = 0;
        vec2 barycentric{0.0f};
        vec3 position{0.0f};
        vec3 normal{0.0f};    ///< geometric, of the side that is the cell
        float pdfArea = 0.0f; ///< per square metre
    };
    void place(const Choice& choice, Place& place) const
    {
        const Piece& piece = pieces_[choice.number];
        const vec2 at = shading::sampleTriangle(choice.u);
        place.record = piece.record;
        place.cell = piece.cell;
        place.barycentric = piece.corners[0] + at.x * (piece.corners[1] - piece.corners[0]) +
                            at.y * (piece.corners[2] - piece.corners[0]);
        place.position = piece.origin + at.x * piece.edge1 + at.y * piece.edge2;
        place.normal = piece.normal;
        place.pdfArea = choice.probability * piece.pdfArea;
    }
    /// Density, per square metre, of the samples on a cell; 0 where there are none.
    [[nodiscard]] float pdfArea(const Guide& guide, uint32_t cell) const;

private:
    /// Triangle, or part of one, that lies in a cell.
    struct Piece {
        uint32_t record = 0;
        uint32_t cell = 0;
        std::array<vec2, 3> corners; ///< barycentric
        vec3 origin{0.0f};
        vec3 edge1{0.0f};
        vec3 edge2{0.0f};
        vec3 normal{0.0f};    ///< of its side
        float pdfArea = 0.0f; ///< given the patch
        [[nodiscard]] float area() const { return 0.5f * glm::length(glm::cross(edge1, edge2)); }
    };
    /// One of as many equal parts as a patch has pieces: a share of it stands for a piece of the same number, the rest
    /// for another (Walker 1977, "An Efficient Method for Generating Discrete Random Variables with General
    /// Distributions"; filled as in Vose 1991, "A Linear Algorithm for Generating Random Numbers with a Given
    /// Distribution").
    struct Column {
        float share = 1.0f;
        uint32_t other = 0; ///< how many pieces farther on, modulo 2^32
    };
    struct Patch {
        uint32_t firstPiece = 0;
        uint32_t pieceCount = 0;
    };
    struct Member {
        uint32_t patch = ~0u;
        float pdfArea = 0.0f; ///< given the patch; 0: no member of any
    };
    struct Entry {
        uint32_t patch = 0;
        float probability = 0.0f;
    };
    [[nodiscard]] uint32_t patchOf(uint32_t cell) const { return cell < members_.size() ? members_[cell].patch : ~0u; }
    /// How often a guide's samples are of a patch.
    [[nodiscard]] float probability(const Guide& guide, uint32_t patch) const;
    [[nodiscard]] float probability(const List& list, uint32_t patch) const;
    struct Seen;
    struct Receivers;
    void makeGuides(std::span<const CellLight> cells, float texelMeters, const Sightings& sightings);
    void makePatches(std::span<const CellLight> cells, std::span<const uint32_t> timesSeen, float texelMeters);
    struct Least {
        float sightings = 0.0f;
        float noise = 0.0f;
    };
    struct Sight;
    class Company;
    float addGuide(const Receivers& receivers, uint32_t cube, const Least& least, Guide& guide);
    template<typename Weight> List addList(std::span<const Seen> seen, const Weight& weight);
    void addFar(const Receivers& receivers, std::span<const uint32_t> cubeOfGuide, std::span<const float> illuminances,
                Company& company);
    template<typename Body> void forPieces(const RadianceCache& cache, const RayTracer& tracer, const Body& body) const;
    void keepPatches(const RadianceCache& cache, const RayTracer& tracer, std::size_t texels);
    static void fillColumns(std::span<double> shares, std::span<Column> columns);
    void findPieces(const RadianceCache& cache, const RayTracer& tracer, std::span<const CellLight> cells);

    std::vector<Patch> patches_;
    std::vector<Piece> pieces_;         ///< patch by patch
    std::vector<Column> columns_;       ///< as many
    std::vector<Member> members_;       ///< by cell
    std::vector<uint32_t> guideOfCell_; ///< or ~0
    std::vector<Guide> guides_;
    std::vector<Entry> entries_;   ///< guide by guide, in ascending order of patches
    std::vector<float> entryEnds_; ///< probability of the guide's entries up to each
};

} // namespace halflight
