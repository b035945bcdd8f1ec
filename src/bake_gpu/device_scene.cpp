#include "bake_gpu/device_scene.h"

#include "bake_gpu/scene_lists.h"
#include "shading/srgb_table.h"

#include <algorithm>

namespace halflight {
namespace {

/// SceneData in shaders/bake/scene.glsl.
struct Addresses {
    VkDeviceAddress tree, slots, faces, masked, masks, pictures, texels, glass, glassNumbers, glassTriangles, linear;
    float scale;
    uint32_t tinted;
};

VkAccelerationStructureInstanceKHR instanceOf(const BakeGeometry::Instance* place, uint32_t slot, VkDeviceAddress tree)
{
    VkAccelerationStructureInstanceKHR instance{};
    const mat3 linear = place != nullptr ? place->linear : mat3(1.0f);
    const vec3 origin = place != nullptr ? place->origin : vec3(0.0f);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) instance.transform.matrix[row][column] = linear[column][row];
        instance.transform.matrix[row][3] = origin[row];
    }
    instance.instanceCustomIndex = slot & 0xffffffu;
    instance.mask = 0xff;
    // No flag for facing: it is found in the mesh's space, where fronts are counter-clockwise, mirrored or not.
    instance.accelerationStructureReference = tree;
    return instance;
}

gpu::Tree treeOf(gpu::Device& device, const SceneLists::Mesh& mesh, const gpu::Buffer& positions, uint32_t vertexCount)
{
    std::vector<gpu::Buffer> indices;
    std::vector<gpu::TriangleList> lists;
    for (const SceneLists::Geometry& geometry : mesh.geometries) {
        indices.push_back(bufferOf(device, geometry.corners));
        lists.push_back({positions.address(), vertexCount, indices.back().address(), uint32_t(geometry.corners.size()),
                         geometry.opaque});
    }
    return {device, std::span<const gpu::TriangleList>(lists)};
}

} // namespace

DeviceScene::DeviceScene(gpu::Device& device, const RayScene& scene) : tinted_(scene.anyTinted())
{
    const SceneLists lists(scene);
    positions_ = bufferOf(device, scene.geometry().positions);
    for (const SceneLists::Mesh& mesh : lists.meshes)
        meshes_.push_back(treeOf(device, mesh, positions_, uint32_t(scene.geometry().positions.size())));
    std::vector<VkAccelerationStructureInstanceKHR> instances;
    for (const SceneLists::Instance& i : lists.instances)
        instances.push_back(instanceOf(i.place, i.firstSlot, meshes_[i.mesh].address()));
    tree_ = gpu::Tree(device, std::span<const VkAccelerationStructureInstanceKHR>(instances));
    slots_ = bufferOf(device, lists.slots);
    places_ = lists.slots;
    places_.insert(places_.end(), lists.unseen.begin(), lists.unseen.end());
    std::sort(places_.begin(), places_.end(),
              [](const shading::GpuSlot& a, const shading::GpuSlot& b) { return a.firstHit < b.firstHit; });
    faces_ = bufferOf(device, lists.faces);
    masked_ = bufferOf(device, lists.masked);
    masks_ = bufferOf(device, lists.masks);
    pictures_ = bufferOf(device, lists.pictures);
    texels_ = bufferOf(device, lists.texels);
    if (tinted_) {
        glass_ = bufferOf(device, lists.glass.glass);
        glassNumbers_ = bufferOf(device, lists.glass.numbers);
        glassTriangles_ = bufferOf(device, lists.glass.triangles);
        linear_ = bufferOf(device, std::span<const float>(shading::kLinearFromSrgb8));
    }
    const Addresses addresses{tree_.address(),         slots_.address(),          faces_.address(),  masked_.address(),
                              masks_.address(),        pictures_.address(),       texels_.address(), glass_.address(),
                              glassNumbers_.address(), glassTriangles_.address(), linear_.address(), scene.sceneScale(),
                              tinted_ ? 1u : 0u};
    addresses_ = bufferOf(device, std::span<const Addresses>(&addresses, 1));
}

uint32_t DeviceScene::maskedOf(uint32_t hitIndex) const
{
    const auto after =
        std::upper_bound(places_.begin(), places_.end(), hitIndex,
                         [](uint32_t index, const shading::GpuSlot& slot) { return index < slot.firstHit; });
    if (after == places_.begin()) return shading::kNone;
    const shading::GpuSlot& slot = *(after - 1);
    return slot.firstMasked == shading::kNone ? shading::kNone : slot.firstMasked + (hitIndex - slot.firstHit);
}

std::size_t DeviceScene::bytes() const
{
    std::size_t bytes = tree_.bytes();
    for (const gpu::Tree& mesh : meshes_) bytes += mesh.bytes();
    for (const gpu::Buffer* buffer : {&positions_, &slots_, &faces_, &masked_, &masks_, &pictures_, &texels_, &glass_,
                                      &glassNumbers_, &glassTriangles_, &linear_})
        bytes += buffer->size();
    return bytes;
}

} // namespace halflight
