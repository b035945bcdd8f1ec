#pragma once
// Acceleration structures: trees of triangles, and the tree of their instances.

#include "gpu/compute.h"

#include <span>

namespace halflight::gpu {

using UniqueTree = Unique<VkAccelerationStructureKHR, &Functions::DestroyAccelerationStructureKHR>;

/// Usage of buffers that trees are built from.
constexpr VkBufferUsageFlags kTreeInput =
    kAddressed | VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;

/// Triangles of one geometry of a tree.
struct TriangleList {
    VkDeviceAddress positions = 0; ///< three floats each, 12 bytes apart
    uint32_t vertexCount = 0;
    VkDeviceAddress indices = 0; ///< three 32-bit numbers each
    uint32_t count = 0;
    bool opaque = false; ///< rays do not call the any-hit shader, unless they ask for it
};

class Tree {
public:
    Tree() = default;
    /// Of triangles. Waits until it is built; its input may go then.
    Tree(Device& device, std::span<const TriangleList> lists);
    /// Of instances, whose input goes as well.
    Tree(Device& device, std::span<const VkAccelerationStructureInstanceKHR> instances);

    [[nodiscard]] VkDeviceAddress address() const { return address_; }
    [[nodiscard]] VkDeviceSize bytes() const { return storage_.size(); }

private:
    void build(Device& device, VkAccelerationStructureTypeKHR type,
               std::span<const VkAccelerationStructureGeometryKHR> geometries, std::span<const uint32_t> counts);

    Buffer storage_;
    UniqueTree tree_;
    VkDeviceAddress address_ = 0;
};

} // namespace halflight::gpu
