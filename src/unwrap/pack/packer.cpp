#include "unwrap/pack/packer.h"

#include "unwrap/pack/page_bits.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace halflight::charts {
namespace {

/// Lays items down one after another, and can take them back.
class Packing {
public:
    Packing(ivec2 size, int padding, const ShapeTable& shapes) : page_(size, padding), tried_(shapes.count()) {}

    bool place(const std::vector<Shape>& shapes, Placement& placement, const Shape*& used)
    {
        int bestEnd = 1 << 30;
        used = nullptr;
        for (const bool fromTop : {false, true}) {
            for (const Shape& shape : shapes) {
                // Shapes of one size come one after another: the next finds no place before the last one's.
                const auto hint = firstRow_.find(key(shape));
                const int row = hint == firstRow_.end() ? 0 : hint->second;
                if (fromTop && row == 0) continue;
                const auto at = find(shape, ivec2(0, fromTop ? 0 : row), bestEnd - shape.size.y);
                if (!at) continue;
                bestEnd = at->y + shape.size.y;
                placement.at = *at;
                placement.orientation = shape.orientation;
                used = &shape;
            }
            if (used != nullptr) break;
        }
        if (used == nullptr) return false;
        page_.mark(*used, placement.at);
        firstRow_[key(*used)] = placement.at.y;
        return true;
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

    std::optional<ivec2> find(const Shape& shape, ivec2 start, int yEnd)
    {
        const auto before = [](ivec2 a, ivec2 b) { return a.y != b.y ? a.y < b.y : a.x < b.x; };
        Tried& tried = tried_[shape.number];
        const bool known = !before(start, tried.from) && !before(tried.to, start);
        const ivec2 begin = known ? tried.to : start;
        const auto at = page_.find(shape, begin, yEnd);
        tried = {known ? tried.from : start, at ? *at : yEnd > begin.y ? ivec2(0, yEnd) : begin};
        return at;
    }

    static uint64_t key(const Shape& shape) { return uint64_t(shape.size.x) << 32 | uint64_t(shape.size.y); }

    PageBits page_;
    std::unordered_map<uint64_t, int> firstRow_;
    std::vector<Tried> tried_; ///< by Shape::number
};

std::vector<uint32_t> largestFirst(const std::vector<PackItem>& items)
{
    std::vector<uint32_t> order(items.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto size = [&](uint32_t i) { return items[i].footprint->width() + items[i].footprint->height(); };
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return size(a) > size(b); });
    return order;
}

} // namespace

std::optional<Block> packOnePage(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                 const Progress& progress)
{
    std::size_t texels = 0;
    for (const PackItem& item : items) texels += item.footprint->count();
    if (texels > std::size_t(pageSize.x) * std::size_t(pageSize.y)) return std::nullopt;
    const ShapeTable shapes(items, padding, progress);
    Packing packing(pageSize, padding, shapes);
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
    const ShapeTable shapes(items, padding, progress);
    // Groups by area, largest first; within a group, items by size.
    uint32_t groupCount = 0;
    for (const PackItem& item : items) groupCount = std::max(groupCount, item.group + 1);
    std::vector<std::vector<uint32_t>> members(groupCount);
    std::vector<std::size_t> area(groupCount, 0);
    for (const uint32_t i : largestFirst(items)) {
        members[items[i].group].push_back(i);
        area[items[i].group] += items[i].footprint->dilated((padding + 1) / 2).count();
    }
    std::vector<uint32_t> order(groupCount);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return area[a] > area[b]; });

    const std::size_t pageArea = std::size_t(pageSize.x) * std::size_t(pageSize.y);
    std::vector<Placement> placements(items.size());
    std::vector<uint32_t> waiting = order;
    for (int page = 0; !waiting.empty() && !progress.cancelled(); ++page) {
        Packing packing(pageSize, padding, shapes);
        std::vector<uint32_t> left;
        std::size_t used = 0, placedGroups = 0;
        int failures = 0;
        for (const uint32_t group : waiting) {
            constexpr int kPatience = 64; // groups in a row that found no room
            if (used + area[group] > pageArea + pageArea / 16 || failures > kPatience || progress.cancelled()) {
                left.push_back(group);
                continue;
            }
            std::vector<std::pair<const Shape*, ivec2>> done;
            bool fits = true;
            for (const uint32_t i : members[group]) {
                const Shape* shape = nullptr;
                fits = !progress.cancelled() && packing.place(shapes.of(i), placements[i], shape);
                if (!fits) break;
                done.emplace_back(shape, placements[i].at);
            }
            if (fits) {
                for (const uint32_t i : members[group]) placements[i].page = page;
                used += area[group];
                ++placedGroups;
                failures = 0;
            } else {
                for (const auto& [shape, at] : done) packing.takeBack(*shape, at);
                left.push_back(group);
                ++failures;
            }
        }
        // A group that found no room on an empty page never will.
        if (placedGroups == 0) {
            left.erase(left.begin());
            --page;
        }
        waiting = std::move(left);
    }
    return placements;
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
