// Open Image Denoise for gathered light, chart by chart.
#include "bake/denoise/denoise.h"
#include "bake/texels/texel_places.h"

#include "halflight/base/parallel.h"

#if HALFLIGHT_OIDN
#include <OpenImageDenoise/oidn.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#endif

namespace halflight {

#if HALFLIGHT_OIDN

namespace {

/// Width of the extrapolated margin around a chart.
constexpr int kMarginTexels = 16;
/// Narrower charts stay unfiltered: few of their texels have neighbours on all sides.
constexpr int kNarrowTexels = 6;
/// The network's input for the mean of all texels, close to its own choice for an image.
constexpr float kMiddleGrey = 0.18f;

/// Width or height of the image for a chart: 2^n or 1.5 × 2^n from 32 on, so that few filters have to be built.
int tileSide(int texels)
{
    int side = 32;
    while (side < texels + 2 * kMarginTexels) side = side % 3 == 0 ? side / 3 * 4 : side / 2 * 3;
    return side;
}

struct Chart {
    ivec2 min{1 << 30};
    ivec2 max{-1};
    std::size_t first = 0; ///< of its texels
    std::size_t count = 0;

    [[nodiscard]] ivec2 size() const { return max - min + 1; }
    [[nodiscard]] ivec2 tile() const { return {tileSide(size().x), tileSide(size().y)}; }
};

/// The image of one chart.
class Tile {
public:
    explicit Tile(ivec2 size) : image_(size.x, size.y), result_(size.x, size.y), ring_(size.x, size.y) {}

    ImageRgb32f& image() { return image_; }
    ImageRgb32f& result() { return result_; }
    void clear()
    {
        std::fill(ring_.texels().begin(), ring_.texels().end(), kEmpty);
        edge_.clear();
    }
    void put(ivec2 at, vec3 value)
    {
        image_(at.x, at.y) = value;
        ring_(at.x, at.y) = 0;
        edge_.push_back(at);
    }
    /// Extends the values ring by ring: each texel is the mean of its neighbours in earlier rings.
    void extend()
    {
        for (uint32_t ring = 1; !edge_.empty(); ++ring) {
            next_.clear();
            for (const ivec2 at : edge_) {
                forNeighbours(at, [&](ivec2 other) {
                    if (ring_(other.x, other.y) != kEmpty) return;
                    ring_(other.x, other.y) = ring;
                    next_.push_back(other);
                });
            }
            for (const ivec2 at : next_) {
                vec3 sum(0.0f);
                float count = 0.0f;
                forNeighbours(at, [&](ivec2 other) {
                    if (ring_(other.x, other.y) >= ring) return;
                    sum += image_(other.x, other.y);
                    ++count;
                });
                image_(at.x, at.y) = sum / count;
            }
            edge_.swap(next_);
        }
    }

private:
    static constexpr uint32_t kEmpty = ~0u;
    template<typename Body> void forNeighbours(ivec2 at, const Body& body) const
    {
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const ivec2 other = at + ivec2(dx, dy);
                const bool in = other.x >= 0 && other.y >= 0 && other.x < image_.width() && other.y < image_.height();
                if (in && other != at) body(other);
            }
        }
    }

    ImageRgb32f image_;
    ImageRgb32f result_;
    Image<uint32_t> ring_; ///< by texel; 0: a value of the chart
    std::vector<ivec2> edge_;
    std::vector<ivec2> next_;
};

Status statusOf(oidn::DeviceRef& device)
{
    const char* message = nullptr;
    if (device.getError(message) == oidn::Error::None) return {};
    return Error{ErrorCode::DeviceFailed,
                 std::string("Open Image Denoise: ") + (message != nullptr ? message : "unknown error")};
}

/// The charts, sorted by the sizes of their tiles, and their valid texels.
std::vector<Chart> chartsBySize(const TexelMap& map, const std::vector<IrradianceEstimate>& estimates,
                                std::vector<uint32_t>& texels)
{
    for (std::size_t i = 0; i < map.texels.size(); ++i) {
        if (estimates[i].valid) texels.push_back(uint32_t(i));
    }
    std::stable_sort(texels.begin(), texels.end(),
                     [&](uint32_t a, uint32_t b) { return map.texels[a].chart < map.texels[b].chart; });
    std::vector<Chart> charts;
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const Texel& texel = map.texels[texels[i]];
        if (i == 0 || map.texels[texels[i - 1]].chart != texel.chart) charts.push_back({.first = i});
        Chart& chart = charts.back();
        chart.min = glm::min(chart.min, ivec2(texel.x, texel.y));
        chart.max = glm::max(chart.max, ivec2(texel.x, texel.y));
        ++chart.count;
    }
    std::erase_if(charts, [](const Chart& c) { return std::min(c.size().x, c.size().y) < kNarrowTexels; });
    std::stable_sort(charts.begin(), charts.end(), [](const Chart& a, const Chart& b) {
        return a.tile().x != b.tile().x ? a.tile().x < b.tile().x : a.tile().y < b.tile().y;
    });
    return charts;
}

/// Replaces the gathered light of an estimate; the mean direction stays.
void replaceGathered(IrradianceEstimate& e, vec3 gathered)
{
    gathered = glm::max(gathered, vec3(0.0f));
    const float before = luminance(e.irradiance);
    const float after = luminance(e.direct + gathered);
    if (!std::isfinite(after)) return;
    e.irradiance = e.direct + gathered;
    if (before > 0.0f) e.moment *= after / before;
}

} // namespace

bool hasOpenImageDenoise()
{
    return true;
}

Status imageDenoise(const TexelMap& map, const std::vector<vec3>& gathered, std::vector<IrradianceEstimate>& estimates,
                    const Progress& progress)
{
    std::vector<uint32_t> texels;
    const std::vector<Chart> charts = chartsBySize(map, estimates, texels);
    double mean = 0.0;
    for (const uint32_t i : texels) mean += double(luminance(gathered[i])) / double(texels.size());
    if (charts.empty() || !(mean > 0.0)) return {};

    // The CPU device needs no other memory.
    oidn::DeviceRef device = oidn::newDevice(oidn::DeviceType::CPU);
    if (!device) return Error{ErrorCode::DeviceFailed, "Open Image Denoise has no device for this processor"};
    device.set("numThreads", threadCount());
    device.set("setAffinity", false);
    device.commit();
    if (Status status = statusOf(device); !status) return status;

    std::size_t done = 0;
    for (std::size_t first = 0; first < charts.size();) {
        const ivec2 size = charts[first].tile();
        Tile tile(size);
        oidn::FilterRef filter = device.newFilter("RTLightmap");
        if (!filter) return Error{ErrorCode::DeviceFailed, "this Open Image Denoise has no filter for lightmaps"};
        const auto width = std::size_t(size.x);
        const auto height = std::size_t(size.y);
        filter.setImage("color", tile.image().data(), oidn::Format::Float3, width, height);
        filter.setImage("output", tile.result().data(), oidn::Format::Float3, width, height);
        // One scale for all charts, so that both sides of a seam are filtered alike.
        filter.set("inputScale", kMiddleGrey / float(mean));
        filter.commit();
        for (; first < charts.size() && charts[first].tile() == size; ++first) {
            if (progress.cancelled()) return Error{ErrorCode::Cancelled, "interrupted"};
            const Chart& chart = charts[first];
            const std::span<const uint32_t> own(texels.data() + chart.first, chart.count);
            const ivec2 corner = chart.min - (size - chart.size()) / 2;
            const auto placeOf = [&](uint32_t i) { return ivec2(map.texels[i].x, map.texels[i].y) - corner; };
            tile.clear();
            for (const uint32_t i : own) tile.put(placeOf(i), gathered[i]);
            tile.extend();
            filter.execute();
            if (Status status = statusOf(device); !status) return status;
            for (const uint32_t i : own) {
                const ivec2 at = placeOf(i);
                replaceGathered(estimates[i], tile.result()(at.x, at.y));
            }
            progress("denoise", double(++done) / double(charts.size()));
        }
    }
    return {};
}

#else

bool hasOpenImageDenoise()
{
    return false;
}

Status imageDenoise(const TexelMap& /*map*/, const std::vector<vec3>& /*gathered*/,
                    std::vector<IrradianceEstimate>& /*estimates*/, const Progress& /*progress*/)
{
    return Error{ErrorCode::Unsupported, "this build of Halflight has no Open Image Denoise"};
}

#endif

} // namespace halflight
