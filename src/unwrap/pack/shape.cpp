#include "unwrap/pack/shape.h"

#include "halflight/base/hash.h"
#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <unordered_map>
#include <utility>

namespace halflight::charts {
namespace {

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

Hash128 hashOf(const PackItem& item)
{
    Hasher hasher;
    hasher.add(item.footprint->width()).add(item.footprint->height()).add(item.mayTurn);
    for (int y = 0; y < item.footprint->height(); ++y) {
        const std::span<const uint64_t> row = item.footprint->row(y);
        hasher.bytes(row.data(), row.size_bytes());
    }
    return hasher.hash();
}

/// Counts what is different.
class Numbers {
public:
    /// The number of those with that hash, and whether it is new.
    std::pair<uint32_t, bool> of(const Hash128& hash)
    {
        const auto [entry, isNew] = numbers_.try_emplace(hash, uint32_t(numbers_.size()));
        return {entry->second, isNew};
    }
    [[nodiscard]] std::size_t count() const { return numbers_.size(); }

private:
    struct Low {
        std::size_t operator()(const Hash128& hash) const { return std::size_t(hash.low); }
    };
    std::unordered_map<Hash128, uint32_t, Low> numbers_;
};

} // namespace

ShapeTable::ShapeTable(const std::vector<PackItem>& items, int padding, const Progress& progress)
{
    // Very many items are small ones, which fit about as well in two orientations, and take a quarter of the time.
    constexpr std::size_t kMany = 50000;
    constexpr std::array<int, 8> kAll = {0, 1, 2, 3, 4, 5, 6, 7};
    constexpr std::array<int, 2> kUprightAndLying = {0, 4}; // swapped x and y
    const std::span<const int> orientations =
        items.size() < kMany ? std::span<const int>(kAll) : std::span<const int>(kUprightAndLying);
    std::vector<Hash128> hashes(items.size());
    parallelFor(items.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) hashes[i] = hashOf(items[i]);
    });
    Numbers kinds;
    std::vector<uint32_t> firstOfKind;
    for (uint32_t i = 0; i < items.size(); ++i) {
        const auto [kind, isNew] = kinds.of(hashes[i]);
        if (isNew) firstOfKind.push_back(i);
        kindOf_.push_back(kind);
    }
    shapes_.resize(firstOfKind.size());
    parallelFor(shapes_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end && !progress.cancelled(); ++k)
            shapes_[k] = shapesOf(items[firstOfKind[k]], padding, orientations);
    });
    Numbers numbers;
    for (std::vector<Shape>& kind : shapes_) {
        for (Shape& shape : kind) shape.number = numbers.of(Hasher().add(shape.texels).add(shape.size).hash()).first;
    }
    count_ = numbers.count();
}

} // namespace halflight::charts
