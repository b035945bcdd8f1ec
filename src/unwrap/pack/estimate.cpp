#include "unwrap/pack/estimate.h"

#include "halflight/base/mathematics.h"
#include "halflight/unwrap/unwrap.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace halflight::charts {
namespace {

/// Pages for everything at a density, objects larger than a page included.
double estimatePages(const std::vector<GroupLayout>& groups, double texelsPerMeter, const PageSettings& settings)
{
    return estimateTexels(groups, settings.padding).at(texelsPerMeter) /
           (double(settings.pageSize) * double(settings.pageSize));
}

} // namespace

double texelsPerUnit(const GroupLayout& group, double texelsPerMeter)
{
    const double density = texelsPerMeter * group.densityScale;
    return group.authored ? density * std::sqrt(group.authored->worldArea / group.authored->uvArea) : density;
}

/// Size of the largest thing that has to stay in one piece, in layout units.
double largestExtent(const GroupLayout& group)
{
    if (group.authored) {
        const dvec2 size = group.authored->most - group.authored->least;
        return std::max(size.x, size.y);
    }
    double extent = 0.0;
    for (const Chart& chart : group.layout.charts) extent = std::max({extent, chart.size.x, chart.size.y});
    return extent;
}

double TexelEstimate::densityOf(double texels) const
{
    constexpr double kLeast = 1e-9, kMost = 1e9;
    const double left = texels - constant;
    if (left <= 0.0) return kLeast;
    const double divisor = linear + std::sqrt(linear * linear + 4.0 * square * left);
    return divisor > 0.0 ? std::clamp(2.0 * left / divisor, kLeast, kMost) : kMost;
}

TexelEstimate estimateObject(const GroupLayout& group, int padding)
{
    const double grow = 0.5 * (padding + 1);
    const double scale = texelsPerUnit(group, 1.0);
    if (group.authored) {
        // Authored charts keep their gaps: the rectangle that holds them counts.
        const dvec2 size = (group.authored->most - group.authored->least) * scale;
        return {size.x * size.y, 2.0 * grow * (size.x + size.y), 4.0 * grow * grow};
    }
    TexelEstimate sum;
    for (const Chart& chart : group.layout.charts) {
        sum.square += chart.area * scale * scale;
        sum.linear += 0.55 * chart.perimeter * scale * grow * 2.0;
        sum.constant += 4.0 * grow * grow * 0.8;
    }
    if (group.layout.charts.empty()) sum.constant = 4.0 * grow * grow;
    return sum;
}

TexelEstimate estimateTexels(const std::vector<GroupLayout>& groups, int padding)
{
    TexelEstimate sum;
    for (const GroupLayout& group : groups) {
        const TexelEstimate own = estimateObject(group, padding);
        const auto count = double(group.group.objects.size());
        sum.square += own.square * count;
        sum.linear += own.linear * count;
        sum.constant += own.constant * count;
    }
    return sum;
}

/// Refuses what would need far too many pages, before any work on it.
Status checkPageCount(const std::vector<GroupLayout>& groups, double texelsPerMeter, const PageSettings& settings)
{
    const double pages = estimatePages(groups, texelsPerMeter, settings);
    if (pages <= kMaxPages) return {};
    const std::string needed =
        fmt::format("{:.4g} texels per metre need about {:.0f} pages of {} x {} texels and {} are the most",
                    texelsPerMeter, std::ceil(pages), settings.pageSize, settings.pageSize, kMaxPages);
    double fits = 0.0, fails = texelsPerMeter;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (fits + fails);
        (estimatePages(groups, middle, settings) <= 0.9 * kMaxPages ? fits : fails) = middle;
    }
    if (fits <= 1e-6 * texelsPerMeter) {
        return Error{ErrorCode::InvalidArgument,
                     needed + ": the objects are too many for any density at this page size", ""};
    }
    const double unit = math::pow(10.0, std::floor(math::log10(fits)) - 1.0); // two digits, rounded down
    return Error{ErrorCode::InvalidArgument,
                 fmt::format("{}: {:.4g} texels per metre would fit", needed, std::floor(fits / unit) * unit), ""};
}

} // namespace halflight::charts
