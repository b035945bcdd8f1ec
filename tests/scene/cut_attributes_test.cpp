// Attributes of vertices that cutting a mesh added, in the formats of a file.

#include "scene/write/meshes/cut_attributes.h"

#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

namespace halflight::cut_attributes_test {
namespace {

template<typename T, std::size_t N> AccessorView viewOf(const std::array<T, N>& numbers, int components, int type)
{
    AccessorView view;
    view.data = reinterpret_cast<const std::byte*>(numbers.data());
    view.strideBytes = view.bytesPerElement = std::size_t(components) * sizeof(T);
    view.count = N / std::size_t(components);
    view.componentType = type;
    view.components = components;
    return view;
}

template<typename T> std::vector<T> numbersOf(const std::vector<std::byte>& bytes)
{
    std::vector<T> numbers(bytes.size() / sizeof(T));
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

/// A vertex a quarter of the way, and one half way from there to the end.
const std::vector<CutVertex> kCuts = {{0, 1, 0.25f}, {kCutVertex | 0u, 1, 0.5f}};

TEST(CutAttributesS6, FloatsAreLinear)
{
    const std::array<float, 6> numbers{0.0f, 1.0f, 2.0f, 4.0f, 1.0f, -2.0f};
    const auto made = numbersOf<float>(cutElements(viewOf(numbers, 3, 5126), kCuts, betweenOf("POSITION")));
    EXPECT_EQ(made, (std::vector<float>{1.0f, 1.0f, 1.0f, 2.5f, 1.0f, -0.5f}));
}

TEST(CutAttributesS6, IntegersAreRounded)
{
    const std::array<uint16_t, 4> numbers{0, 65535, 10, 65533};
    const auto made = numbersOf<uint16_t>(cutElements(viewOf(numbers, 2, 5123), kCuts, betweenOf("TEXCOORD_0")));
    EXPECT_EQ(made, (std::vector<uint16_t>{3, 65535, 7, 65534}));
}

TEST(CutAttributesS6, DirectionsKeepTheirLength)
{
    const std::array<int8_t, 8> numbers{127, 0, 0, -127, 0, 127, 0, 127};
    const auto normals = numbersOf<int8_t>(cutElements(viewOf(numbers, 4, 5120), kCuts, betweenOf("TANGENT")));
    for (const std::size_t i : {0u, 4u}) {
        const float length = std::sqrt(float(normals[i] * normals[i] + normals[i + 1] * normals[i + 1]));
        EXPECT_NEAR(length, 127.0f, 1.0f);
    }
    EXPECT_NEAR(float(normals[1]) / float(normals[0]), 1.0f / 3.0f, 0.02f);
    EXPECT_EQ(normals[3], -127) << "the sign of the nearer end";
    EXPECT_EQ(normals[7], 127);
}

TEST(CutAttributesS6, JointsAndFeaturesAreOfTheNearerEnd)
{
    const std::array<uint8_t, 8> numbers{3, 1, 4, 1, 9, 2, 6, 5};
    for (const char* name : {"JOINTS_0", "_FEATURE_ID_0"}) {
        const auto made = numbersOf<uint8_t>(cutElements(viewOf(numbers, 4, 5121), kCuts, betweenOf(name)));
        EXPECT_EQ(made, (std::vector<uint8_t>{3, 1, 4, 1, 9, 2, 6, 5})) << name;
    }
}

} // namespace
} // namespace halflight::cut_attributes_test
