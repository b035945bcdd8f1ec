#include "bake_gpu/gather/gather_tables.h"

#include "halflight/base/parallel.h"

namespace halflight {
namespace {

std::vector<vec3> normalsOf(const RayTracer& surfaces)
{
    std::vector<vec3> normals(surfaces.hitTriangleCount());
    parallelFor(normals.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            normals[i] = surfaces.geometry().geometricNormal(surfaces.triangleAt(uint32_t(i)));
    });
    return normals;
}

} // namespace

void addScene(gpu::Device& device, const GpuScene& scene, const PathTracer& paths, std::vector<gpu::Buffer>& buffers,
              GatherAddresses& to)
{
    const auto keep = [&](const auto& list) {
        buffers.push_back(bufferOf(device, list));
        return buffers.back().address();
    };
    const SkyLight& skyLight = paths.light().sky();
    const Sky& sky = skyLight.sky();
    const ImageRgb32f* picture = sky.picture.get();
    to.scene = scene.address();
    to.normals = keep(normalsOf(paths.surfaces()));
    to.picture = keep(picture != nullptr ? std::span<const vec3>(picture->texels()) : std::span<const vec3>());
    to.all.sky = (skyLight.black() ? 0u : shading::kSky) | (picture != nullptr ? shading::kSkyPicture : 0u);
    to.all.zenith = sky.zenith;
    to.all.horizon = sky.horizon;
    to.all.ground = sky.ground;
    to.all.pictureSize = picture != nullptr ? picture->size() : ivec2(0);
    to.all.turn = skyLight.turn();
    to.all.limit = skyLight.limit();
}

} // namespace halflight
