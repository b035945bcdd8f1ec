#pragma once
// Numbers that glTF 2.0 gives a meaning.

namespace halflight::gltf {

// componentType of accessors.
inline constexpr int kByte = 5120;
inline constexpr int kUnsignedByte = 5121;
inline constexpr int kShort = 5122;
inline constexpr int kUnsignedShort = 5123;
inline constexpr int kUnsignedInt = 5125;
inline constexpr int kFloat = 5126;

// target of buffer views.
inline constexpr int kVertices = 34962;
inline constexpr int kIndices = 34963;

// mode of primitives, of those that have names here.
inline constexpr int kPoints = 0;
inline constexpr int kTriangles = 4;
inline constexpr int kTriangleStrip = 5;

// Of samplers.
inline constexpr int kNearest = 9728;
inline constexpr int kLinear = 9729;
inline constexpr int kRepeat = 10497;
inline constexpr int kClampToEdge = 33071;
inline constexpr int kMirroredRepeat = 33648;

} // namespace halflight::gltf
