#include "unwrap/pack/shape.h"

#include <algorithm>
#include <bit>

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
    shape.hash = Hasher().add(shape.texels).add(shape.padded).hash();
    return shape;
}

} // namespace

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

} // namespace halflight::charts
