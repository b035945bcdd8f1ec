#include "bake_gpu/shadows/shadows.h"

#include "bake_gpu/shadows/shadow_layout.h"
#include "bake_gpu/shadows/shadow_pipelines.h"

#include "shaders/bake/shadow_lifts.comp.h"
#include "shaders/bake/shadow_rays.comp.h"
#include "shaders/bake/shadow_sums.comp.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>
#include <vector>

namespace halflight {
namespace {

using shading::GpuRay;
using shading::GpuShadowSource;
using shading::kShadowHalf;

static_assert(sizeof(DeviceShadows::Item) == sizeof(shading::GpuShadowItem));
static_assert(sizeof(LitSum) == sizeof(shading::GpuLitSum) && LitRange::kLit == int(shading::kLitByte));
static_assert(ShadowRays::kHalf == int(kShadowHalf));

/// Tables in shaders/bake/shadows.glsl.
struct ShadowTableAddresses {
    VkDeviceAddress surfaces, lights, firstBatches, radii, angles;
    uint32_t firstBatchCount;
    float sceneScale;
    uint32_t tinted;
};
/// Lists in shaders/bake/shadows.glsl.
struct ShadowLists {
    VkDeviceAddress texels, fragments, items, sources, numbers, rays, passed, weights, sums, colors, counts;
    uint32_t itemCount;
};
struct ShadowPush {
    VkDeviceAddress tables, lists;
};

static_assert(DeviceShadows::kItemsAtOnce % shading::kItemsOfChunk == 0);

/// Whether shadow rays of some triangle start above it.
bool anySmoothTriangle(const BakeGeometry& geometry)
{
    return std::any_of(geometry.triangles.begin(), geometry.triangles.end(), [&](uvec3 corners) {
        const vec3 normal = geometry.normals[corners.x];
        return geometry.normals[corners.y] != normal || geometry.normals[corners.z] != normal;
    });
}

} // namespace

ShadowPipelines::ShadowPipelines(const gpu::Device& device)
    : lifts(device, bake_shadow_lifts_comp, sizeof(ShadowPush)),
      rays(device, bake_shadow_rays_comp, sizeof(ShadowPush)), sums(device, bake_shadow_sums_comp, sizeof(ShadowPush))
{}

std::vector<std::span<const uint32_t>> ShadowPipelines::shaders()
{
    return {bake_shadow_lifts_comp, bake_shadow_rays_comp, bake_shadow_sums_comp};
}

/// Buffers of one call. What the processor writes and reads is in its memory, and the device reaches it there.
struct GpuShadows::Workspace {
    Workspace(gpu::Device& device, const BakeGeometry& geometry, std::size_t lightCount, bool tinted)
        : texels(device, geometry, kItemsAtOnce),
          items(device, kItemsAtOnce * sizeof(Item), gpu::kAddressed, gpu::MemoryUse::Upload),
          sources(device, kMaxShadowSources * sizeof(GpuShadowSource), gpu::kAddressed, gpu::MemoryUse::Upload),
          numbers(device, lightCount * sizeof(uint32_t), gpu::kAddressed, gpu::MemoryUse::Upload),
          lists(device, sizeof(ShadowLists), gpu::kAddressed, gpu::MemoryUse::Upload),
          rays(device, kItemsAtOnce * kShadowHalf * sizeof(GpuRay), gpu::kAddressed, gpu::MemoryUse::Device),
          passed(device, kItemsAtOnce * kShadowHalf * (tinted ? sizeof(vec3) : sizeof(float)), gpu::kAddressed,
                 gpu::MemoryUse::Device),
          weights(device, kItemsAtOnce * kShadowHalf * sizeof(float), gpu::kAddressed, gpu::MemoryUse::Device),
          sums(device, kItemsAtOnce * sizeof(LitSum), gpu::kAddressed, gpu::MemoryUse::Readback),
          counts(device, sizeof(uint32_t), gpu::kAddressed, gpu::MemoryUse::Readback)
    {
        if (tinted) colors = {device, kItemsAtOnce * sizeof(vec3), gpu::kAddressed, gpu::MemoryUse::Readback};
    }
    TexelLists texels;
    gpu::Buffer items, sources, numbers, lists, rays, passed, weights, sums, counts;
    gpu::Buffer colors; ///< empty where no glass has a colour
};

GpuShadows::~GpuShadows() = default;

GpuShadows::GpuShadows(BakeDevice& device, const DeviceScene& scene, const GpuSurfaces& surfaces,
                       const ShadowTables& tables)
    : device_(device), scene_(scene), geometry_(tables.surfaces.geometry()), firstLight_(tables.lights.data()),
      anySmooth_(anySmoothTriangle(geometry_))
{
    gpu::Device& on = device.device();
    const auto keep = [&](const auto& list) {
        buffers_.push_back(bufferOf(on, std::span(std::as_const(list))));
        return buffers_.back().address();
    };
    const std::vector<shading::LightSource> lights(tables.lights.begin(), tables.lights.end());
    const StratifiedPattern::Tables pattern = tables.pattern.tables();
    const std::span<const uint32_t> batches = ShadowGroup::firstBatches();
    const ShadowTableAddresses t{surfaces.address(),
                                 keep(lights),
                                 keep(batches),
                                 keep(pattern.radii),
                                 keep(pattern.angles),
                                 uint32_t(batches.size()),
                                 tables.surfaces.sceneScale(),
                                 scene.tinted() ? 1u : 0u};
    tables_ = bufferOf(on, std::span<const ShadowTableAddresses>(&t, 1));
    workspace_ = std::make_unique<Workspace>(on, geometry_, tables.lights.size(), scene.tinted());
}

void GpuShadows::setSources(std::span<const ShadowSource> sources) const
{
    std::vector<GpuShadowSource> list;
    std::vector<uint32_t> numbers;
    for (const ShadowSource& source : sources) {
        list.push_back(
            {uint32_t(numbers.size()), uint32_t(source.lights.lights().size()), source.lit ? 1u : 0u, source.seed});
        for (const PunctualLight* light : source.lights.lights()) numbers.push_back(uint32_t(light - firstLight_));
    }
    assert(list.size() * sizeof(GpuShadowSource) <= workspace_->sources.size());
    assert(numbers.size() * sizeof(uint32_t) <= workspace_->numbers.size()); // a light is in one source
    std::memcpy(workspace_->sources.mapped(), list.data(), list.size() * sizeof(GpuShadowSource));
    std::memcpy(workspace_->numbers.mapped(), numbers.data(), numbers.size() * sizeof(uint32_t));
}

/// Copies items to the workspace, whose first texel has a number in their list of texels.
void GpuShadows::setItems(std::span<const Item> items, uint32_t firstTexel) const
{
    auto* const to = reinterpret_cast<Item*>(workspace_->items.mapped());
    forEachIndex(items.size(), [&](std::size_t i) {
        Item item = items[i];
        item.texel -= firstTexel;
        to[i] = item;
    });
}

Status GpuShadows::trace(const TexelMap& map, const Batch& batch, std::span<LitSum> sums, std::span<vec3> colors,
                         uint64_t& rays) const
{
    const std::lock_guard turn(mutex_);
    setSources(batch.sources);
    try {
        for (std::size_t first = 0; first < batch.items.size(); first += kItemsAtOnce) {
            const std::span<const Item> items =
                batch.items.subspan(first, std::min(batch.items.size() - first, kItemsAtOnce));
            const uint32_t firstTexel = items.front().texel;
            workspace_->texels.set(map, items.back().texel + 1 - firstTexel,
                                   [&](std::size_t i) { return batch.texels[firstTexel + i]; });
            setItems(items, firstTexel);
            rays += traceItems(items.size());
            std::memcpy(sums.data() + first, workspace_->sums.mapped(), items.size() * sizeof(LitSum));
            if (!colors.empty())
                std::memcpy(colors.data() + first, workspace_->colors.mapped(), items.size() * sizeof(vec3));
        }
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    return {};
}

/// Traces the workspace's items and returns the number of rays.
uint32_t GpuShadows::traceItems(std::size_t itemCount) const
{
    Workspace& w = *workspace_;
    std::memset(w.counts.mapped(), 0, w.counts.size());
    const ShadowLists lists{w.texels.texels(),   w.texels.fragments(), w.items.address(),  w.sources.address(),
                            w.numbers.address(), w.rays.address(),     w.passed.address(), w.weights.address(),
                            w.sums.address(),    w.colors.address(),   w.counts.address(), uint32_t(itemCount)};
    std::memcpy(w.lists.mapped(), &lists, sizeof(lists));
    const ShadowPush push{tables_.address(), w.lists.address()};
    const uint32_t count = shading::raysOfChunks(uint32_t(itemCount), kShadowHalf);
    const ShadowPipelines& pipelines = device_.shadows();
    device_.device().execute([&](VkCommandBuffer commands) {
        const std::span<const std::byte> bytes = gpu::bytesOf(push);
        const TracePush trace{scene_.address(), w.rays.address(), w.passed.address(), 0, scene_.tinted()};
        if (anySmooth_) {
            pipelines.lifts.run(commands, bytes, count, shading::kGroupSize);
            TracePush occluded = trace;
            occluded.byChance = 1;
            device_.transmittance(commands, occluded, count);
        }
        pipelines.rays.run(commands, bytes, count, shading::kGroupSize);
        device_.transmittance(commands, trace, count);
        pipelines.sums.run(commands, bytes, itemCount, shading::kGroupSize);
        gpu::fullBarrier(device_.device(), commands);
    });
    uint32_t traced = 0;
    std::memcpy(&traced, w.counts.mapped(), sizeof(traced));
    return traced;
}

} // namespace halflight
