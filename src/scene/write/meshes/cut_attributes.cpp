#include "scene/write/meshes/cut_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace halflight {
namespace {

constexpr int kMostComponents = 16; // of a matrix

using Numbers = std::array<float, kMostComponents>; // as stored: not normalized

template<typename T> void put(std::byte* to, float number)
{
    T stored{};
    if constexpr (std::is_floating_point_v<T>) {
        stored = number;
    } else {
        stored = T(std::llround(number));
    }
    std::memcpy(to, &stored, sizeof(stored));
}

void putNumber(std::byte* element, int componentType, int c, float number)
{
    switch (componentType) {
    case gltf::kByte:
        return put<int8_t>(element + c, number);
    case gltf::kUnsignedByte:
        return put<uint8_t>(element + c, number);
    case gltf::kShort:
        return put<int16_t>(element + 2 * c, number);
    case gltf::kUnsignedShort:
        return put<uint16_t>(element + 2 * c, number);
    case gltf::kUnsignedInt:
        return put<uint32_t>(element + 4 * c, number);
    default:
        return put<float>(element + 4 * c, number);
    }
}

float lengthOf(const Numbers& n)
{
    return std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

template<typename T> void negate(std::byte* at)
{
    T number{};
    std::memcpy(&number, at, sizeof(number));
    if constexpr (!std::is_floating_point_v<T>) number = std::max(number, T(-std::numeric_limits<T>::max()));
    number = T(-number);
    std::memcpy(at, &number, sizeof(number));
}

} // namespace

void negateElement(std::byte* element, int componentType, int components)
{
    for (int c = 0; c < components; ++c) {
        if (componentType == gltf::kFloat) negate<float>(element + 4 * c);
        if (componentType == gltf::kShort) negate<int16_t>(element + 2 * c);
        if (componentType == gltf::kByte) negate<int8_t>(element + c);
    }
}

Between betweenOf(const std::string& attribute)
{
    if (attribute == "NORMAL" || attribute == "TANGENT") return Between::Direction;
    return attribute.starts_with("JOINTS_") || attribute.starts_with("_") ? Between::Nearest : Between::Linear;
}

std::vector<std::byte> cutElements(const AccessorView& view, std::span<const CutVertex> cut, Between between)
{
    const std::size_t size = view.bytesPerElement;
    std::vector<std::byte> elements(cut.size() * size);
    AccessorView made = view; // of the elements so far
    made.owned.clear();
    made.data = elements.data();
    made.strideBytes = size;
    made.count = cut.size();
    const auto viewOf = [&](uint32_t vertex) -> const AccessorView& {
        return (vertex & kCutVertex) != 0 ? made : view;
    };
    const auto bytesOf = [&](uint32_t vertex) { return viewOf(vertex).at(vertex & ~kCutVertex); };
    const auto numbersOf = [&](uint32_t vertex) {
        AccessorView stored;
        const AccessorView& of = viewOf(vertex);
        stored.data = of.at(vertex & ~kCutVertex);
        stored.strideBytes = size;
        stored.count = 1;
        stored.componentType = view.componentType;
        stored.components = view.components;
        stored.bytesPerElement = size;
        Numbers numbers{};
        for (int c = 0; c < view.components; ++c) numbers[std::size_t(c)] = stored.number(0, c);
        return numbers;
    };
    for (std::size_t i = 0; i < cut.size(); ++i) {
        std::byte* const element = elements.data() + i * size;
        std::memcpy(element, bytesOf(cut[i].share < 0.5f ? cut[i].from : cut[i].to), size);
        if (between == Between::Nearest) continue;
        const Numbers from = numbersOf(cut[i].from);
        const Numbers to = numbersOf(cut[i].to);
        Numbers here{};
        for (std::size_t c = 0; c < std::size_t(view.components); ++c) here[c] = cut[i].between(from[c], to[c]);
        int components = view.components;
        if (between == Between::Direction) {
            components = std::min(components, 3);
            const float length = lengthOf(here);
            if (!(length > 0.0f)) continue;
            const float scale = cut[i].between(lengthOf(from), lengthOf(to)) / length;
            for (std::size_t c = 0; c < 3; ++c) here[c] *= scale;
        }
        for (int c = 0; c < components; ++c) putNumber(element, view.componentType, c, here[std::size_t(c)]);
    }
    return elements;
}

} // namespace halflight
