#include "unwrap/result/shared_texels.h"

#include "halflight/base/atomic_ref.h"
#include "halflight/base/image.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <fmt/format.h>
#include <span>

namespace halflight::charts {
namespace {

/// An object on a page. Its charts have the numbers firstOwner … firstOwner + ownerCount - 1; a kept layout counts as
/// one chart, since its author may let charts meet.
struct Drawn {
    const Object* object = nullptr;
    const Mesh* mesh = nullptr;
    const GroupLayout* group = nullptr;
    uint32_t firstOwner = 0;
    uint32_t ownerCount = 1;

    [[nodiscard]] bool owns(uint32_t owner) const { return owner >= firstOwner && owner - firstOwner < ownerCount; }
};

/// Some triangles of one part.
struct Chunk {
    const Drawn* drawn = nullptr;
    const MeshPart* part = nullptr;
    std::size_t firstTriangle = 0; ///< of the part
    std::size_t triangleCount = 0;
    std::size_t firstOfMesh = 0; ///< number of the part's first triangle among those of the mesh
};

constexpr uint32_t kNobody = 0;

std::vector<std::vector<Drawn>> objectsByPage(const UnwrappedScene& unwrapped, const std::vector<GroupLayout>& groups)
{
    std::vector<std::vector<Drawn>> pages(std::size_t(unwrapped.pageCount));
    for (const GroupLayout& group : groups) {
        for (const int o : group.group.objects) {
            Drawn drawn;
            drawn.object = &unwrapped.scene.objects[std::size_t(o)];
            drawn.mesh = &unwrapped.scene.meshes[std::size_t(drawn.object->mesh)];
            drawn.group = &group;
            if (!group.authored) drawn.ownerCount = uint32_t(std::max<std::size_t>(group.layout.charts.size(), 1));
            pages[std::size_t(drawn.object->lightmap.page)].push_back(drawn);
        }
    }
    for (std::vector<Drawn>& page : pages) {
        uint32_t next = kNobody + 1;
        for (Drawn& drawn : page) {
            drawn.firstOwner = next;
            next += drawn.ownerCount;
        }
    }
    return pages;
}

std::vector<Chunk> chunksOf(const std::vector<Drawn>& page)
{
    constexpr std::size_t kMost = 1024;
    std::vector<Chunk> chunks;
    for (const Drawn& drawn : page) {
        std::size_t firstOfMesh = 0;
        for (const MeshPart& part : drawn.mesh->parts) {
            const std::size_t count = part.triangleCount();
            for (std::size_t t = 0; t < count; t += kMost)
                chunks.push_back({&drawn, &part, t, std::min(kMost, count - t), firstOfMesh});
            firstOfMesh += count;
        }
    }
    return chunks;
}

/// Whose texels are whose on one page, written by all threads at once.
class PageOwners {
public:
    explicit PageOwners(int size) : owners_(size, size, kNobody) {}

    /// Takes the texels that solid triangles touch. False, and the texel in `clash`, where another has one.
    bool takeSolid(const Chunk& chunk, ivec2& clash)
    {
        return forTexels(chunk, true, clash, [&](uint32_t owner, AtomicRef<uint32_t> texel) {
            uint32_t before = texel.load(std::memory_order_relaxed);
            if (before == owner) return true;
            return before == kNobody &&
                   (texel.compare_exchange_strong(before, owner, std::memory_order_relaxed) || before == owner);
        });
    }
    /// The same for triangles without area, which have shrunk to a point of any chart of their object.
    bool takeDegenerate(const Chunk& chunk, ivec2& clash)
    {
        return forTexels(chunk, false, clash, [&](uint32_t owner, AtomicRef<uint32_t> texel) {
            uint32_t before = texel.load(std::memory_order_relaxed);
            if (chunk.drawn->owns(before)) return true;
            return before == kNobody && (texel.compare_exchange_strong(before, owner, std::memory_order_relaxed) ||
                                         chunk.drawn->owns(before));
        });
    }
    [[nodiscard]] uint32_t owner(ivec2 texel) const { return owners_(texel.x, texel.y); }

private:
    template<typename Take> bool forTexels(const Chunk& chunk, bool solid, ivec2& clash, Take take)
    {
        const int size = owners_.width();
        const MeshPart& part = *chunk.part;
        const LightmapBinding& binding = chunk.drawn->object->lightmap;
        const GroupLayout& group = *chunk.drawn->group;
        bool good = true;
        for (std::size_t t = chunk.firstTriangle; t < chunk.firstTriangle + chunk.triangleCount && good; ++t) {
            uint32_t owner = chunk.drawn->firstOwner;
            bool isSolid = true;
            if (!group.authored && !group.layout.charts.empty()) {
                const uint32_t chart = group.layout.chartOfTriangle[chunk.firstOfMesh + t];
                isSolid = chart != kNone;
                if (isSolid) owner += chart;
            }
            if (isSolid != solid) continue;
            dvec2 corners[3];
            for (std::size_t k = 0; k < 3; ++k) // in float, as renderers have it
                corners[k] =
                    dvec2(binding.scale * part.lightmapUv[part.indices[3 * t + k]] + binding.offset) * double(size);
            forTouchedTexels(corners, 0.0, [&](int y, int first, int last) {
                if (y < 0 || y >= size) return;
                for (int x = std::max(first, 0); x <= std::min(last, size - 1) && good; ++x) {
                    good = take(owner, AtomicRef<uint32_t>(owners_(x, y)));
                    if (!good) clash = {x, y};
                }
            });
        }
        return good;
    }

    Image<uint32_t> owners_;
};

std::string nameOf(const Drawn& drawn)
{
    return fmt::format("\"{}\"", drawn.object->name);
}

/// The first clash, in the order of the objects.
Error describe(const std::vector<Chunk>& chunks, const std::vector<Drawn>& page, int number, int pageSize)
{
    PageOwners owners(pageSize);
    const Chunk* culprit = nullptr;
    ivec2 clash(-1);
    for (const bool solid : {true, false}) {
        for (const Chunk& chunk : chunks) {
            if (solid ? owners.takeSolid(chunk, clash) : owners.takeDegenerate(chunk, clash)) continue;
            culprit = &chunk;
            break;
        }
        if (culprit != nullptr) break;
    }
    std::string who = "objects"; // never left so: what clashes for many threads does for one
    if (culprit != nullptr) {
        const Drawn& second = *culprit->drawn;
        const auto first =
            std::find_if(page.begin(), page.end(), [&](const Drawn& d) { return d.owns(owners.owner(clash)); });
        who = first->object == second.object ? fmt::format("two charts of object {}", nameOf(second))
                                             : fmt::format("objects {} and {}", nameOf(*first), nameOf(second));
    }
    return {ErrorCode::Unsupported,
            fmt::format("{} would share texel {},{} of lightmap page {}: this is a fault of the unwrapper, please "
                        "report it; other settings (--uv, --padding, --texels-per-meter) may avoid it",
                        who, clash.x, clash.y, number),
            ""};
}

} // namespace

Status checkSharedTexels(const UnwrappedScene& unwrapped, const std::vector<GroupLayout>& groups,
                         const Progress& progress)
{
    const std::vector<std::vector<Drawn>> pages = objectsByPage(unwrapped, groups);
    for (std::size_t p = 0; p < pages.size(); ++p) {
        const std::vector<Chunk> chunks = chunksOf(pages[p]);
        PageOwners owners(unwrapped.pageSize);
        std::atomic<bool> good = true;
        for (const bool solid : {true, false}) {
            parallelFor(chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t c = begin; c < end && good && !progress.cancelled(); ++c) {
                    ivec2 clash;
                    if (!(solid ? owners.takeSolid(chunks[c], clash) : owners.takeDegenerate(chunks[c], clash)))
                        good = false;
                }
            });
        }
        if (progress.cancelled()) return cancelledError();
        if (!good) return describe(chunks, pages[p], int(p), unwrapped.pageSize);
    }
    return {};
}

} // namespace halflight::charts
