#include "gpu/acceleration.h"

namespace halflight::gpu {

Tree::Tree(Device& device, std::span<const TriangleList> lists)
{
    std::vector<VkAccelerationStructureGeometryKHR> geometries;
    std::vector<uint32_t> counts;
    for (const TriangleList& list : lists) {
        VkAccelerationStructureGeometryKHR geometry{.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
                                                    .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR};
        geometry.geometry.triangles = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
                                       .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                                       .vertexData = {.deviceAddress = list.positions},
                                       .vertexStride = 3 * sizeof(float),
                                       .maxVertex = list.vertexCount - 1,
                                       .indexType = VK_INDEX_TYPE_UINT32,
                                       .indexData = {.deviceAddress = list.indices}};
        // An any-hit shader that multiplies must see each triangle once.
        geometry.flags = VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR;
        if (list.opaque) geometry.flags |= VK_GEOMETRY_OPAQUE_BIT_KHR;
        geometries.push_back(geometry);
        counts.push_back(list.count);
    }
    build(device, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, geometries, counts);
}

Tree::Tree(Device& device, std::span<const VkAccelerationStructureInstanceKHR> instances)
{
    const Buffer input(device, instances.size_bytes(), kTreeInput, MemoryUse::Device);
    Uploader uploader(device);
    uploader.buffer(input, instances.data(), instances.size_bytes());
    uploader.finish();
    VkAccelerationStructureGeometryKHR geometry{.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
                                                .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR};
    geometry.geometry.instances = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
                                   .data = {.deviceAddress = input.address()}};
    const auto count = uint32_t(instances.size());
    build(device, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, {&geometry, 1}, {&count, 1});
}

void Tree::build(Device& device, VkAccelerationStructureTypeKHR type,
                 std::span<const VkAccelerationStructureGeometryKHR> geometries, std::span<const uint32_t> counts)
{
    VkAccelerationStructureBuildGeometryInfoKHR info{
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
        .type = type,
        .flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR,
        .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
        .geometryCount = uint32_t(geometries.size()),
        .pGeometries = geometries.data()};
    VkAccelerationStructureBuildSizesInfoKHR sizes{.sType =
                                                       VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    device.vk.GetAccelerationStructureBuildSizesKHR(device.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                                    &info, counts.data(), &sizes);
    storage_ = Buffer(device, sizes.accelerationStructureSize,
                      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR | kAddressed, MemoryUse::Device);
    const VkAccelerationStructureCreateInfoKHR create{.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
                                                      .buffer = storage_.get(),
                                                      .size = sizes.accelerationStructureSize,
                                                      .type = type};
    VkAccelerationStructureKHR tree = VK_NULL_HANDLE;
    check(device.vk.CreateAccelerationStructureKHR(device.handle(), &create, nullptr, &tree), "create a tree");
    tree_ = UniqueTree(device, tree);
    const VkDeviceSize alignment = device.treeLimits().minAccelerationStructureScratchOffsetAlignment;
    const Buffer scratch(device, sizes.buildScratchSize + alignment, kAddressed, MemoryUse::Device);
    info.dstAccelerationStructure = tree;
    info.scratchData.deviceAddress = (scratch.address() + alignment - 1) / alignment * alignment;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
    for (const uint32_t count : counts) ranges.push_back({.primitiveCount = count});
    const VkAccelerationStructureBuildRangeInfoKHR* first = ranges.data();
    device.execute([&](VkCommandBuffer commands) {
        device.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &first);
        fullBarrier(device, commands);
    });
    const VkAccelerationStructureDeviceAddressInfoKHR whose{
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR, .accelerationStructure = tree};
    address_ = device.vk.GetAccelerationStructureDeviceAddressKHR(device.handle(), &whose);
}

} // namespace halflight::gpu
