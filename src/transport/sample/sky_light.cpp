#include "transport/sample/sky_light.h"

#include "halflight/base/mathematics.h"
#include "halflight/scene/sky_picture.h"

#include <algorithm>

namespace halflight {
namespace {

/// The dim part's largest luminance as a multiple of the picture's mean. It bounds the variance of a ray relative to
/// the mean's square. A lower limit would pay for shadow rays towards clouds.
constexpr double kBright = 4.0;

} // namespace

SkyLight::SkyLight(const Sky& sky)
    : sky_(sky), picture_(sky_.picture.get()), turn_(math::cos(sky.rotationRadians), math::sin(sky.rotationRadians))
{
    if (picture_ == nullptr) return;
    double mean = 0.0;
    for (int y = 0; y < picture_->height(); ++y) {
        double row = 0.0;
        for (int x = 0; x < picture_->width(); ++x) row += double(luminance((*picture_)(x, y)));
        const double h = picture_->height();
        mean += row / picture_->width() * skyShareBetween(y / h, (y + 1) / h);
    }
    limit_ = float(kBright * mean);
    if (limit_ > 0.0f) findBrightAreas();
}

void SkyLight::findBrightAreas()
{
    const int width = picture_->width();
    std::vector<double> weights;
    double total = 0.0;
    for (int row = 0; row <= picture_->height(); ++row) {
        const vec2 range = shading::skyRowRange(row, picture_->height());
        const double steradians = 4.0 * double(kPi) * skyShareBetween(range.x, range.y) / width;
        for (int column = 0; column < width; ++column) {
            const double weight =
                double(brightLuminance(shading::skyArea(column, row, vec2(0.0f), picture_->size()))) * steradians;
            if (!(weight > 0.0)) continue;
            areas_.push_back(uint32_t(row) * uint32_t(width) + uint32_t(column));
            weights.push_back(weight);
            total += weight;
        }
    }
    for (double& weight : weights) weight /= total;
    bins_.resize(areas_.size());
    fillAliasTable(weights, bins_);
    brightIlluminance_ = float(total);
}

SkyLight::Place SkyLight::placeOf(vec3 direction) const
{
    return shading::skyPlaceOf(direction, turn_, picture_->size());
}

template<typename Value> vec3 SkyLight::interpolate(const Place& place, const Value& value) const
{
    const vec3 upper = glm::mix(value((*picture_)(place.low.x, place.low.y)),
                                value((*picture_)(place.high.x, place.low.y)), place.between.x);
    const vec3 lower = glm::mix(value((*picture_)(place.low.x, place.high.y)),
                                value((*picture_)(place.high.x, place.high.y)), place.between.x);
    return glm::mix(upper, lower, place.between.y);
}

float SkyLight::dimShare(vec3 texel) const
{
    return shading::skyDimShare(texel, limit_);
}

vec3 SkyLight::pictureRadiance(vec3 direction) const
{
    return interpolate(placeOf(direction), [](vec3 texel) { return texel; });
}

vec3 SkyLight::pictureDim(vec3 direction) const
{
    return interpolate(placeOf(direction), [&](vec3 texel) { return texel * dimShare(texel); });
}

/// Mean over the place's area.
float SkyLight::brightLuminance(const Place& place) const
{
    Place middle = place;
    middle.between = vec2(0.5f);
    return luminance(interpolate(middle, [&](vec3 texel) { return texel * (1.0f - dimShare(texel)); }));
}

// An area is chosen by its mean luminance times its solid angle (Walker's alias method), then a direction uniformly
// within it: the piecewise constant distribution of Pharr, Jakob and Humphreys 2023, "Physically Based Rendering",
// section 12.5, on areas where bilinear filtering is smooth.
SkyLight::Sample SkyLight::sample(vec2 u) const
{
    u.x *= float(areas_.size());
    auto bin = std::min(uint32_t(u.x), uint32_t(areas_.size()) - 1);
    u.x = std::min(u.x - float(bin), 0x1.fffffep-1f);
    bin += bins_[bin].select(u.x);
    const auto width = uint32_t(picture_->width());
    const shading::SkyPoint point =
        shading::skyPointOf(int(areas_[bin] % width), int(areas_[bin] / width), u, turn_, picture_->size());
    Sample result;
    result.direction = point.direction;
    result.radiance = interpolate(point.place, [&](vec3 texel) { return texel * (1.0f - dimShare(texel)); });
    result.pdf = brightLuminance(point.place) / brightIlluminance_;
    return result;
}

float SkyLight::pdf(vec3 direction) const
{
    return samples() ? brightLuminance(placeOf(direction)) / brightIlluminance_ : 0.0f;
}

} // namespace halflight
