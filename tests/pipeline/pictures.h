#pragma once
// Pictures of baked scenes, and how far they are from one another.

#include "halflight/base/image.h"
#include "halflight/base/math.h"
#include "halflight/render/renderer.h"

#include <cmath>
#include <gtest/gtest.h>

namespace halflight {

/// Means of |difference| / reference over pixels, each averaged over 2 x 2 so that edges' antialiasing does not count.
inline double meanRelativeError(const ImageRgba32f& picture, const ImageRgb32f& reference)
{
    double mean = 0.0;
    for (const vec3 c : reference.texels()) mean += luminance(c) / double(reference.texelCount());
    double error = 0.0;
    int count = 0;
    for (int y = 0; y + 1 < reference.height(); y += 2) {
        for (int x = 0; x + 1 < reference.width(); x += 2) {
            double a = 0.0;
            double b = 0.0;
            for (int i = 0; i < 4; ++i) {
                a += luminance(vec3(picture(x + (i & 1), y + (i >> 1)))) / 4.0;
                b += luminance(reference(x + (i & 1), y + (i >> 1))) / 4.0;
            }
            error += std::abs(a - b) / (b + 0.01 * mean);
            ++count;
        }
    }
    return error / count;
}

/// The radiance that the renderer draws; a message of the validation layers is a failure.
inline ImageRgba32f drawPicture(const BakedScene& baked, const Camera& camera, RunMode mode, ivec2 size)
{
    RendererOptions options;
    options.validation = true;
    auto renderer = Renderer::create(options);
    EXPECT_TRUE(renderer) << renderer.error().text();
    EXPECT_TRUE((*renderer)->load(baked));
    RenderSettings settings;
    settings.mode = mode;
    settings.size = size;
    auto frame = (*renderer)->render(camera, settings);
    EXPECT_TRUE(frame) << frame.error().text();
    for (const std::string& message : (*renderer)->validationMessages()) ADD_FAILURE() << message;
    return std::move(frame->radiance);
}

} // namespace halflight
