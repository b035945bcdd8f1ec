#pragma once

#include "halflight/base/image.h"

#include <memory>
#include <utility>

namespace halflight {

/// An image that copies share: a copy takes no memory and no time. edit() makes the texels this object's own first.
/// Copies may be read and dropped on several threads.
template<typename Texel> class SharedImage {
public:
    SharedImage() = default;
    SharedImage(Image<Texel> image) // NOLINT(google-explicit-constructor): takes the place of an Image
        : image_(std::make_shared<Image<Texel>>(std::move(image)))
    {}

    operator const Image<Texel>&() const { return get(); } // NOLINT(google-explicit-constructor)
    [[nodiscard]] int width() const { return get().width(); }
    [[nodiscard]] int height() const { return get().height(); }
    [[nodiscard]] ivec2 size() const { return get().size(); }
    [[nodiscard]] bool empty() const { return get().empty(); }
    [[nodiscard]] std::size_t texelCount() const { return get().texelCount(); }
    const Texel& operator()(int x, int y) const { return get()(x, y); }
    [[nodiscard]] const Texel* data() const { return get().data(); }
    [[nodiscard]] const std::vector<Texel>& texels() const { return get().texels(); }

    Image<Texel>& edit()
    {
        if (!image_ || image_.use_count() > 1) image_ = std::make_shared<Image<Texel>>(get());
        return *image_;
    }

private:
    [[nodiscard]] const Image<Texel>& get() const
    {
        static const Image<Texel> kNone;
        return image_ ? *image_ : kNone;
    }

    std::shared_ptr<Image<Texel>> image_;
};

} // namespace halflight
