#include "unwrap/pack/packer.h"

#include "halflight/base/hash.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <numeric>
#include <span>

namespace halflight::charts {
namespace {

struct Run {
    int y, x, length;
};

/// A footprint as it is tested and drawn: runs of texels, and runs with the padding around (from -padding, -padding
/// on).
struct Shape {
    ivec2 size{0};
    int orientation = 0;
    std::vector<Run> texels;
    std::vector<Run> padded; ///< in the order of spreadOut()
    Hash128 hash;            ///< of both
};

/// Puts the longest run first, then the others in an order that visits the shape's far ends, its middle, its quarters
/// and so on: what is taken on a page hangs together, so runs far apart are the likeliest to hit something new.
void spreadOut(std::vector<Run>& runs)
{
    const auto longest =
        std::max_element(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.length < b.length; });
    std::vector<Run> ordered{*longest};
    std::vector<char> used(runs.size(), 0);
    used[std::size_t(longest - runs.begin())] = 1;
    const auto take = [&](std::size_t i) {
        if (!used[i]) ordered.push_back(runs[i]);
        used[i] = 1;
    };
    take(0);
    take(runs.size() - 1);
    for (std::size_t step = std::bit_ceil(runs.size()) / 2; step > 0; step /= 2) {
        for (std::size_t i = step; i < runs.size(); i += 2 * step) take(i);
    }
    runs = std::move(ordered);
}

Shape shapeOf(const Footprint& footprint, int orientation, int padding)
{
    Shape shape;
    shape.size = {footprint.width(), footprint.height()};
    shape.orientation = orientation;
    footprint.forRuns([&](int y, int x, int length) { shape.texels.push_back({y, x, length}); });
    footprint.dilated(padding).forRuns([&](int y, int x, int length) { shape.padded.push_back({y, x, length}); });
    spreadOut(shape.padded);
    shape.hash = Hasher().add(shape.texels).add(shape.padded).hash();
    return shape;
}

std::vector<Shape> shapesOf(const PackItem& item, int padding, std::span<const int> orientations)
{
    std::vector<Footprint> different;
    std::vector<Shape> shapes;
    for (const int orientation : orientations.first(item.mayTurn ? orientations.size() : 1)) {
        Footprint turned = item.footprint->oriented(orientation);
        if (std::find(different.begin(), different.end(), turned) != different.end()) continue;
        shapes.push_back(shapeOf(turned, orientation, padding));
        different.push_back(std::move(turned));
    }
    return shapes;
}

/// Free texels of a page as bits, and for each power of two the places where a run of that many free texels begins: a
/// run of any length is free when the two (or more) power-of-two runs that cover it are. So 64 places in a row are
/// tested against one run of a footprint with a handful of word operations.
class Page {
public:
    Page(ivec2 size, int padding)
        : padding_(padding), width_(size.x + 2 * padding), height_(size.y + 2 * padding),
          words_((std::size_t(width_) + 63) / 64 + 2), longestFree_(std::size_t(height_), width_),
          changes_(std::size_t(height_), 0)
    {
        for (auto& level : free_) level.assign(words_ * std::size_t(height_), 0);
        for (int y = 0; y < height_; ++y) {
            uint64_t* row = free_[0].data() + std::size_t(y) * words_;
            for (int x = 0; x < width_; ++x) row[x / 64] |= uint64_t(1) << (x % 64);
            updateRuns(y, 0, width_);
            updateLongest(y);
        }
    }

    /// The first place from the top, then from the left, not before `begin` and at a y below `yEnd`.
    [[nodiscard]] std::optional<ivec2> find(const Shape& shape, ivec2 begin, int yEnd) const
    {
        const int lastX = width_ - 2 * padding_ - shape.size.x;
        yEnd = std::min(yEnd, height_ - 2 * padding_ - shape.size.y + 1);
        if (lastX < 0) return std::nullopt;
        for (int y = begin.y; y < yEnd; ++y) {
            if (!rowsHaveRoom(shape, y)) continue;
            for (int x = y == begin.y ? begin.x : 0; x <= lastX; x += 64) {
                uint64_t places = lastX - x >= 63 ? ~uint64_t(0) : (uint64_t(1) << (lastX - x + 1)) - 1;
                for (const Run& run : shape.padded) {
                    places &= freeRuns(y + run.y, x + run.x, run.length);
                    if (places == 0) break;
                }
                if (places != 0) return ivec2(x + std::countr_zero(places), y);
            }
        }
        return std::nullopt;
    }

    void mark(const Shape& shape, ivec2 at, bool taken = true)
    {
        for (const Run& run : shape.texels) {
            const int y = at.y + run.y + padding_;
            uint64_t* row = free_[0].data() + std::size_t(y) * words_;
            for (int x = at.x + run.x + padding_, end = x + run.length; x < end;) {
                const int bit = x % 64, length = std::min(64 - bit, end - x);
                const uint64_t mask = (length == 64 ? ~uint64_t(0) : (uint64_t(1) << length) - 1) << bit;
                if (taken)
                    row[x / 64] &= ~mask;
                else
                    row[x / 64] |= mask;
                x += length;
            }
            updateRuns(y, at.x + run.x + padding_, at.x + run.x + padding_ + run.length);
            // What was taken can only shorten the longest run: it is looked for now and then.
            uint8_t& changes = changes_[std::size_t(y)];
            if (!taken || ++changes % 16 == 0) updateLongest(y);
        }
    }

private:
    static constexpr int kLevels = 8;

    static uint64_t bitsFrom(const uint64_t* row, int x)
    {
        const uint64_t* word = row + x / 64;
        const int shift = x % 64;
        return shift == 0 ? word[0] : word[0] >> shift | word[1] << (64 - shift);
    }

    /// Whether the rows under the first few runs have a free run of that length anywhere.
    [[nodiscard]] bool rowsHaveRoom(const Shape& shape, int y) const
    {
        constexpr std::size_t kRowsAsked = 16;
        for (std::size_t i = 0, end = std::min(shape.padded.size(), kRowsAsked); i < end; ++i) {
            if (longestFree_[std::size_t(y + shape.padded[i].y)] < shape.padded[i].length) return false;
        }
        return true;
    }

    /// Bit i: the `length` texels from x + i on are free.
    [[nodiscard]] uint64_t freeRuns(int y, int x, int length) const
    {
        const int level = std::min(int(std::bit_width(unsigned(length))) - 1, kLevels - 1), step = 1 << level;
        const uint64_t* row = free_[std::size_t(level)].data() + std::size_t(y) * words_;
        const int wordLimit = int(words_ - 1) * 64;
        uint64_t places = bitsFrom(row, x);
        for (int covered = step; covered < length && places != 0;) {
            const int from = std::min(covered, length - step);
            if (x + from >= wordLimit) return 0;
            places &= bitsFrom(row, x + from);
            covered = from + step;
        }
        return places;
    }

    /// After texels xBegin … xEnd of the row have changed.
    void updateRuns(int y, int xBegin, int xEnd)
    {
        const std::size_t start = std::size_t(y) * words_;
        const auto first = std::size_t(std::max(xBegin - (1 << (kLevels - 1)), 0)) / 64;
        const std::size_t last = std::min(std::size_t(xEnd) / 64, words_ - 1);
        for (int level = 1; level < kLevels; ++level) {
            const uint64_t* from = free_[std::size_t(level) - 1].data() + start;
            uint64_t* to = free_[std::size_t(level)].data() + start;
            const int shift = 1 << (level - 1);
            const std::size_t whole = std::size_t(shift) / 64;
            for (std::size_t w = first; w <= last; ++w) {
                uint64_t ahead = 0;
                if (shift < 64) {
                    ahead = from[w] >> shift | (w + 1 < words_ ? from[w + 1] << (64 - shift) : 0);
                } else {
                    ahead = w + whole < words_ ? from[w + whole] : 0;
                }
                to[w] = from[w] & ahead;
            }
        }
    }

    void updateLongest(int y)
    {
        const std::size_t start = std::size_t(y) * words_;
        int longest = 0;
        for (std::size_t w = 0, run = 0; w < words_; ++w) {
            uint64_t word = free_[0][start + w];
            if (word == ~uint64_t(0)) {
                run += 64;
                longest = std::max(longest, int(run));
                continue;
            }
            int left = 64;
            while (left > 0) {
                const int ones = std::min(std::countr_one(word), left);
                run += std::size_t(ones);
                longest = std::max(longest, int(run));
                left -= ones;
                if (left == 0) break;
                word = ones < 64 ? word >> ones : 0;
                run = 0;
                const int zeros = std::min(std::countr_zero(word), left);
                left -= zeros;
                if (left == 0) break;
                word >>= zeros;
            }
        }
        longestFree_[std::size_t(y)] = longest;
    }

    int padding_, width_, height_; ///< the border of `padding` texels all round is free and never drawn to
    std::size_t words_;
    std::vector<uint64_t> free_[kLevels];
    std::vector<int> longestFree_; ///< by row: no free run is longer
    std::vector<uint8_t> changes_; ///< by row, since long ago
};

/// Lays items down one after another, and can take them back.
class Packing {
public:
    Packing(ivec2 size, int padding) : page_(size, padding) {}

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
        tried_.clear();
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
        Tried& tried = tried_[shape.hash];
        const bool known = !before(start, tried.from) && !before(tried.to, start);
        const ivec2 begin = known ? tried.to : start;
        const auto at = page_.find(shape, begin, yEnd);
        tried = {known ? tried.from : start, at ? *at : yEnd > begin.y ? ivec2(0, yEnd) : begin};
        return at;
    }

    static uint64_t key(const Shape& shape) { return uint64_t(shape.size.x) << 32 | uint64_t(shape.size.y); }

    Page page_;
    std::unordered_map<uint64_t, int> firstRow_;
    std::map<Hash128, Tried> tried_; ///< by Shape::hash
};

std::vector<uint32_t> largestFirst(const std::vector<PackItem>& items)
{
    std::vector<uint32_t> order(items.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto size = [&](uint32_t i) { return items[i].footprint->width() + items[i].footprint->height(); };
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return size(a) > size(b); });
    return order;
}

/// Some are empty when cancelled.
std::vector<std::vector<Shape>> allShapes(const std::vector<PackItem>& items, int padding, const Progress& progress)
{
    // Very many items are small ones, which fit about as well in two orientations, and take a quarter of the time.
    constexpr std::size_t kMany = 50000;
    constexpr std::array<int, 8> kAll = {0, 1, 2, 3, 4, 5, 6, 7};
    constexpr std::array<int, 2> kUprightAndLying = {0, 4}; // swapped x and y
    const std::span<const int> orientations =
        items.size() < kMany ? std::span<const int>(kAll) : std::span<const int>(kUprightAndLying);
    std::vector<std::vector<Shape>> shapes(items.size());
    parallelFor(items.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end && !progress.cancelled(); ++i)
            shapes[i] = shapesOf(items[i], padding, orientations);
    });
    return shapes;
}

} // namespace

std::vector<Placement> packOnePage(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                   const Progress& progress)
{
    std::size_t texels = 0;
    for (const PackItem& item : items) texels += item.footprint->count();
    if (texels > std::size_t(pageSize.x) * std::size_t(pageSize.y)) return {};
    const std::vector<std::vector<Shape>> shapes = allShapes(items, padding, progress);
    Packing packing(pageSize, padding);
    std::vector<Placement> placements(items.size());
    for (const uint32_t i : largestFirst(items)) {
        const Shape* used = nullptr;
        if (progress.cancelled() || !packing.place(shapes[i], placements[i], used)) return {};
        placements[i].page = 0;
    }
    return placements;
}

std::vector<Placement> packPages(const std::vector<PackItem>& items, ivec2 pageSize, int padding,
                                 const Progress& progress)
{
    const std::vector<std::vector<Shape>> shapes = allShapes(items, padding, progress);
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
        Packing packing(pageSize, padding);
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
                fits = !progress.cancelled() && packing.place(shapes[i], placements[i], shape);
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
    const std::vector<std::vector<Shape>> shapes = allShapes(items, padding, progress);
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
        Packing packing({width, height}, padding);
        Block block;
        block.placements.resize(items.size());
        bool fits = true;
        for (const uint32_t i : order) {
            const Shape* used = nullptr;
            fits = !progress.cancelled() && packing.place(shapes[i], block.placements[i], used);
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
