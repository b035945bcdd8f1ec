#include "unwrap/pack/packer.h"

#include "halflight/base/parallel.h"
#include "unwrap/pack/page_bits.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <numeric>
#include <queue>
#include <unordered_map>

namespace halflight::charts {
namespace {

/// Lays items down one after another, and can take them back. `onAllThreads`: the shapes of an item are tried at one
/// time.
class Packing {
public:
    Packing(ivec2 size, int padding, const ShapeTable& shapes, bool onAllThreads = false)
        : page_(size, padding), tried_(shapes.count()), onAllThreads_(onAllThreads)
    {}

    /// Where an item ends highest on the page, in the first shape of those that do.
    bool place(const std::vector<Shape>& shapes, Placement& placement, const Shape*& used)
    {
        used = nullptr;
        for (const bool fromTop : {false, true}) {
            std::vector<std::optional<ivec2>> places(shapes.size());
            std::atomic<int> bestEnd = 1 << 30;
            const auto tryShapes = [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) places[i] = findAbove(shapes[i], fromTop, bestEnd);
            };
            if (onAllThreads_ && isLong(shapes))
                parallelFor(shapes.size(), 1, tryShapes);
            else
                tryShapes(0, shapes.size());
            for (std::size_t i = 0; i < shapes.size(); ++i) {
                if (!places[i] || places[i]->y + shapes[i].size.y > bestEnd) continue;
                used = &shapes[i];
                placement.at = *places[i];
                placement.orientation = used->orientation;
                page_.mark(*used, placement.at);
                firstRow_[key(*used)] = placement.at.y;
                filled_ = std::max(filled_, int(bestEnd));
                return true;
            }
        }
        return false;
    }

    void takeBack(const Shape& shape, ivec2 at)
    {
        page_.mark(shape, at, false);
        firstRow_.clear();
        std::fill(tried_.begin(), tried_.end(), Tried());
    }

private:
    /// Places in reading order without room for a shape, one after another: pages only fill, so it stays so.
    struct Tried {
        ivec2 from{0};
        ivec2 to{0};
    };

    /// The row that the search for a shape begins at: shapes of one size come one after another, and the next finds no
    /// place before the last one's.
    [[nodiscard]] int firstRowOf(const Shape& shape) const
    {
        const auto hint = firstRow_.find(key(shape));
        return hint == firstRow_.end() ? 0 : hint->second;
    }

    /// Whether a place is one of those that are known to have no room for a shape, or the one after them.
    [[nodiscard]] bool isTried(const Shape& shape, ivec2 at) const
    {
        const auto before = [](ivec2 a, ivec2 b) { return a.y != b.y ? a.y < b.y : a.x < b.x; };
        const Tried& tried = tried_[shape.number];
        return !before(at, tried.from) && !before(tried.to, at);
    }

    /// Whether the search is worth more than one thread: most items are like the one before, and find room at once.
    [[nodiscard]] bool isLong(const std::vector<Shape>& shapes) const
    {
        constexpr int kRows = 2048; // take one thread some 170 µs; to call fifteen others and to wait takes 60
        int rows = 0;
        for (const Shape& shape : shapes) {
            const ivec2 start(0, firstRowOf(shape));
            rows += std::max(filled_ - (isTried(shape, start) ? tried_[shape.number].to.y : start.y), 0);
        }
        return rows > kRows;
    }

    /// The first place at which a shape ends at bestEnd or above, which becomes its end.
    std::optional<ivec2> findAbove(const Shape& shape, bool fromTop, std::atomic<int>& bestEnd)
    {
        const int row = firstRowOf(shape);
        if (fromTop && row == 0) return std::nullopt;
        int best = bestEnd;
        const auto at = find(shape, ivec2(0, fromTop ? 0 : row), best - shape.size.y + 1);
        if (!at) return std::nullopt;
        const int end = at->y + shape.size.y;
        while (end < best && !bestEnd.compare_exchange_weak(best, end)) {
        }
        return at;
    }

    std::optional<ivec2> find(const Shape& shape, ivec2 start, int yEnd)
    {
        Tried& tried = tried_[shape.number];
        const bool known = isTried(shape, start);
        const ivec2 begin = known ? tried.to : start;
        const auto at = page_.find(shape, begin, yEnd);
        tried = {known ? tried.from : start, at ? *at : yEnd > begin.y ? ivec2(0, yEnd) : begin};
        return at;
    }

    static uint64_t key(const Shape& shape) { return uint64_t(shape.size.x) << 32 | uint64_t(shape.size.y); }

    PageBits page_;
    std::unordered_map<uint64_t, int> firstRow_;
    std::vector<Tried> tried_; ///< by Shape::number, of which an item has each but once
    int filled_ = 0;           ///< rows in which something lies
    bool onAllThreads_;
};

std::vector<uint32_t> largestFirst(const std::vector<PackItem>& items)
{
    std::vector<uint32_t> order(items.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto size = [&](uint32_t i) { return items[i].footprint->width() + items[i].footprint->height(); };
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return size(a) > size(b); });
    return order;
}

/// Items that stay together, and the texels that they take.
struct PackGroups {
    std::vector<std::vector<uint32_t>> members; ///< largest first
    std::vector<std::size_t> area;              ///< with half of the padding
};

PackGroups groupsOf(const std::vector<PackItem>& items, int padding)
{
    PackGroups groups;
    uint32_t count = 0;
    for (const PackItem& item : items) count = std::max(count, item.group + 1);
    groups.members.resize(count);
    groups.area.resize(count, 0);
    for (const uint32_t i : largestFirst(items)) {
        groups.members[items[i].group].push_back(i);
        groups.area[items[i].group] += items[i].footprint->dilated((padding + 1) / 2).count();
    }
    return groups;
}

/// Fills pages with whole groups.
class PageFiller {
public:
    PageFiller(const std::vector<PackItem>& items, ivec2 pageSize, int padding, const Progress& progress)
        : groups_(groupsOf(items, padding)), shapes_(items, padding, progress), pageSize_(pageSize), padding_(padding),
          progress_(progress), placements_(items.size())
    {}

    std::vector<Placement> run()
    {
        std::vector<uint32_t> waiting(groups_.area.size());
        std::iota(waiting.begin(), waiting.end(), 0u);
        std::stable_sort(waiting.begin(), waiting.end(),
                         [&](uint32_t a, uint32_t b) { return groups_.area[a] > groups_.area[b]; });
        for (int page = 0; !waiting.empty() && !progress_.cancelled();) {
            std::vector<std::vector<uint32_t>> dealt = deal(waiting);
            const std::vector<uint8_t> isUsed = fillPages(page, dealt);
            waiting.clear();
            for (std::size_t p = 0; p < dealt.size(); ++p) {
                // A group that found no room on an empty page never will.
                if (isUsed[p] == 0 && !dealt[p].empty()) dealt[p].erase(dealt[p].begin());
                waiting.insert(waiting.end(), dealt[p].begin(), dealt[p].end());
            }
            std::stable_sort(waiting.begin(), waiting.end(),
                             [&](uint32_t a, uint32_t b) { return groups_.area[a] > groups_.area[b]; });
            page = closeGaps(page, isUsed);
        }
        return std::move(placements_);
    }

private:
    [[nodiscard]] std::size_t pageArea() const { return std::size_t(pageSize_.x) * std::size_t(pageSize_.y); }

    /// Deals groups to three quarters of the pages that they need, each to the page that has least: every page gets
    /// more than it holds. Bit masks of pages at one time take 64 MB, or those of one page.
    [[nodiscard]] std::vector<std::vector<uint32_t>> deal(const std::vector<uint32_t>& waiting) const
    {
        std::size_t area = 0;
        for (const uint32_t group : waiting) area += groups_.area[group];
        constexpr std::size_t kMostTexels = std::size_t(1) << 26;
        const std::size_t most = std::max<std::size_t>(kMostTexels / pageArea(), 1);
        const std::size_t count = std::clamp<std::size_t>(area * 3 / 4 / pageArea(), 1, most);
        std::vector<std::vector<uint32_t>> dealt(count);
        using Page = std::pair<std::size_t, std::size_t>; // area, number
        std::priority_queue<Page, std::vector<Page>, std::greater<>> emptiest;
        for (std::size_t p = 0; p < count; ++p) emptiest.emplace(0, p);
        for (const uint32_t group : waiting) {
            const auto [own, p] = emptiest.top();
            emptiest.pop();
            dealt[p].push_back(group);
            emptiest.emplace(own + groups_.area[group], p);
        }
        std::erase_if(dealt, [](const std::vector<uint32_t>& own) { return own.empty(); });
        return dealt;
    }

    /// A page that is being filled.
    struct OpenPage {
        Packing packing;
        std::size_t used = 0;
    };

    /// Fills pages at one time, each with its own groups, then with those that others left. Returns by page whether
    /// anything lies on it.
    std::vector<uint8_t> fillPages(int firstPage, std::vector<std::vector<uint32_t>>& dealt)
    {
        const std::size_t count = dealt.size();
        std::vector<OpenPage> pages;
        for (std::size_t p = 0; p < count; ++p) pages.push_back({Packing(pageSize_, padding_, shapes_)});
        for (std::size_t shift = 0; shift < count; ++shift) {
            parallelFor(count, 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t p = begin; p < end; ++p)
                    fill(pages[p], firstPage + int(p), dealt[(p + shift) % count]);
            });
        }
        std::vector<uint8_t> isUsed;
        for (const OpenPage& page : pages) isUsed.push_back(page.used > 0 ? 1 : 0);
        return isUsed;
    }

    /// Lays down what finds room; the others are left.
    void fill(OpenPage& page, int number, std::vector<uint32_t>& groups)
    {
        constexpr int kPatience = 64; // groups in a row that found no room
        std::vector<uint32_t> left;
        int failures = 0;
        for (const uint32_t group : groups) {
            const bool isHopeless = page.used + groups_.area[group] > pageArea() + pageArea() / 16;
            if (isHopeless || failures > kPatience || progress_.cancelled()) {
                left.push_back(group);
            } else if (lay(group, number, page.packing)) {
                page.used += groups_.area[group];
                failures = 0;
            } else {
                left.push_back(group);
                ++failures;
            }
        }
        groups = std::move(left);
    }

    /// All items of a group, or none.
    bool lay(uint32_t group, int page, Packing& packing)
    {
        std::vector<std::pair<const Shape*, ivec2>> done;
        for (const uint32_t i : groups_.members[group]) {
            const Shape* shape = nullptr;
            if (progress_.cancelled() || !packing.place(shapes_.of(i), placements_[i], shape)) {
                for (const auto& [laid, at] : done) packing.takeBack(*laid, at);
                return false;
            }
            done.emplace_back(shape, placements_[i].at);
        }
        for (const uint32_t i : groups_.members[group]) placements_[i].page = page;
        return true;
    }

    /// Gives pages that are in use numbers without gaps; returns the next one.
    int closeGaps(int first, const std::vector<uint8_t>& isUsed)
    {
        std::vector<int> numbers(isUsed.size(), -1);
        int next = first;
        for (std::size_t p = 0; p < isUsed.size(); ++p)
            if (isUsed[p] != 0) numbers[p] = next++;
        for (Placement& placement : placements_)
            if (placement.page >= first) placement.page = numbers[std::size_t(placement.page - first)];
        return next;
    }

    PackGroups groups_;
    ShapeTable shapes_;
    ivec2 pageSize_;
    int padding_;
    const Progress& progress_;
    std::vector<Placement> placements_;
};

} // namespace

std::optional<Block> packOnePage(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                 const Progress& progress)
{
    std::size_t texels = 0;
    for (const PackItem& item : items) texels += item.footprint->count();
    if (texels > std::size_t(pageSize.x) * std::size_t(pageSize.y)) return std::nullopt;
    const ShapeTable shapes(items, padding, progress);
    Packing packing(pageSize, padding, shapes, true);
    Block block;
    block.placements.resize(items.size());
    for (const uint32_t i : largestFirst(items)) {
        const Shape* used = nullptr;
        if (progress.cancelled() || !packing.place(shapes.of(i), block.placements[i], used)) return std::nullopt;
        block.placements[i].page = 0;
        block.size = glm::max(block.size, block.placements[i].at + used->size);
    }
    return block;
}

std::vector<Placement> packPages(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                 const Progress& progress)
{
    return PageFiller(items, pageSize, padding, progress).run();
}

std::optional<Block> packBlock(const std::vector<PackItem>& items, ivec2 most, int padding, const Progress& progress)
{
    std::size_t area = 0;
    ivec2 least(1);
    int tall = 0;
    for (const PackItem& item : items) {
        area += item.footprint->dilated((padding + 1) / 2).count();
        least = glm::max(least, ivec2(item.footprint->width(), item.footprint->height()));
        tall = std::max(tall, item.footprint->height());
    }
    if (least.x > most.x || least.y > most.y) return std::nullopt;
    const ShapeTable shapes(items, padding, progress);
    const std::vector<uint32_t> order = largestFirst(items);
    std::optional<Block> best;
    const double side = std::sqrt(double(area));
    int lastWidth = 0;
    for (const double factor : {0.8, 0.9, 1.0, 1.1, 1.25}) {
        const int width = std::clamp(int(std::lround(side * factor)), least.x, most.x);
        if (width == lastWidth || progress.cancelled()) continue;
        lastWidth = width;
        const int height =
            int(std::min<std::size_t>(std::size_t(most.y), 2 * area / std::size_t(width) + 4 * std::size_t(tall) + 64));
        Packing packing({width, height}, padding, shapes);
        Block block;
        block.placements.resize(items.size());
        bool fits = true;
        for (const uint32_t i : order) {
            const Shape* used = nullptr;
            fits = !progress.cancelled() && packing.place(shapes.of(i), block.placements[i], used);
            if (!fits) break;
            block.placements[i].page = 0;
            block.size = glm::max(block.size, block.placements[i].at + used->size);
        }
        const auto cost = [&](const Block& b) { return double(b.size.x + padding) * double(b.size.y + padding); };
        if (fits && (!best || cost(block) < cost(*best))) best = std::move(block);
    }
    return best;
}

} // namespace halflight::charts
