#pragma once
// A stand-in for Open Image Denoise's C++ interface, as far as image_denoise.cpp uses it, for machines whose
// distribution does not carry the library: its filter is the mean of 3 x 3 texels. It checks the order of calls.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

namespace oidn {

enum class DeviceType { Default = 0, CPU = 1 };
enum class Format { Undefined = 0, Float3 = 3 };
enum class Error { None = 0, Unknown = 1, InvalidOperation = 3 };

/// What the library was asked to do, and whether it is to fail.
struct StandIn {
    struct Execution {
        std::size_t width;
        std::size_t height;
        float scale;
    };
    std::vector<Execution> executions;
    bool fails = false;
    bool hasDevice = true;
    bool hasFilter = true;
    Error error = Error::None;
    std::string message;

    void setError(const char* text)
    {
        error = Error::InvalidOperation;
        message = text;
    }
};
inline StandIn standIn;

class FilterRef {
public:
    explicit FilterRef(bool valid) : valid_(valid) {}
    operator bool() const { return valid_; }
    void setImage(const char* name, void* pointer, Format format, std::size_t width, std::size_t height)
    {
        if (format != Format::Float3) standIn.setError("unsupported format");
        Image& image = std::strcmp(name, "color") == 0 ? color_ : output_;
        image = {static_cast<float*>(pointer), width, height};
        committed_ = false;
    }
    void set(const char* name, float value)
    {
        if (std::strcmp(name, "inputScale") == 0) scale_ = value;
        committed_ = false;
    }
    void commit()
    {
        if (color_.width != output_.width || color_.height != output_.height) standIn.setError("sizes differ");
        committed_ = true;
    }
    void execute()
    {
        if (!committed_) standIn.setError("changes are not committed");
        if (standIn.fails) standIn.setError("out of luck");
        if (standIn.error != Error::None) return;
        standIn.executions.push_back({color_.width, color_.height, scale_});
        const auto near = [](std::size_t at, std::size_t step, std::size_t size) {
            return std::min(at + step > 0 ? at + step - 1 : 0, size - 1);
        };
        for (std::size_t y = 0; y < color_.height; ++y) {
            for (std::size_t x = 0; x < color_.width; ++x) {
                for (std::size_t c = 0; c < 3; ++c) {
                    float sum = 0.0f;
                    for (std::size_t n = 0; n < 9; ++n)
                        sum += color_.at(near(x, n % 3, color_.width), near(y, n / 3, color_.height), c);
                    output_.at(x, y, c) = sum / 9.0f;
                }
            }
        }
    }

private:
    struct Image {
        float* texels = nullptr;
        std::size_t width = 0;
        std::size_t height = 0;
        [[nodiscard]] float& at(std::size_t x, std::size_t y, std::size_t c) const
        {
            return texels[3 * (y * width + x) + c];
        }
    };
    bool valid_;
    bool committed_ = false;
    float scale_ = 0.0f;
    Image color_;
    Image output_;
};

class DeviceRef {
public:
    operator bool() const { return standIn.hasDevice; }
    void set(const char* /*name*/, bool /*value*/) {}
    void set(const char* /*name*/, int /*value*/) {}
    void commit() { committed_ = true; }
    [[nodiscard]] FilterRef newFilter(const char* type) const
    {
        const bool known = standIn.hasFilter && std::strcmp(type, "RTLightmap") == 0;
        if (!known || !committed_) standIn.setError("no such filter");
        return FilterRef(known && committed_);
    }
    Error getError(const char*& message)
    {
        const Error error = standIn.error;
        standIn.error = Error::None;
        message = error != Error::None ? standIn.message.c_str() : nullptr;
        return error;
    }

private:
    bool committed_ = false;
};

inline DeviceRef newDevice(DeviceType /*type*/ = DeviceType::Default)
{
    return {};
}

} // namespace oidn
