#include "bake_gpu/gather/gather.h"

#include "bake_gpu/gather/component_lists.h"
#include "bake_gpu/gather/gather_layout.h"
#include "transport/lightmap/next_event.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace halflight {
namespace {

using namespace shading;

static_assert(sizeof(DeviceGather::Texel) == sizeof(GpuGatherRequest));
static_assert(sizeof(DeviceGather::Block) == sizeof(GpuBlock) && sizeof(DeviceGather::Sums) == sizeof(GpuSums));
static_assert(sizeof(DeviceGather::Halves) == sizeof(GpuHalves));
static_assert(sizeof(PatchLayout::Surface) == sizeof(GpuSurface) && sizeof(PatchLayout::Elements) == sizeof(uint32_t));
static_assert(sizeof(PatchRadiance) == sizeof(GpuPatch) && sizeof(Guide) == sizeof(GpuSourceGuide));
static_assert(sizeof(Guides::Entry) == sizeof(GpuEntry) && sizeof(SourceClusters::Cluster) == sizeof(GpuCluster));
static_assert(sizeof(SourceClusters::SourceTriangle) == sizeof(GpuSourceTriangle));
static_assert(sizeof(ComponentRadiance) == sizeof(GpuComponentLight));
static_assert(sizeof(AliasBin) == sizeof(GpuAliasBin) && sizeof(SourceClusters::Member) == sizeof(GpuMember));

/// Lists in shaders/bake/gather.glsl.
struct Lists {
    VkDeviceAddress mapTexels, fragments, requests, texels, points, blocks, rays, hits, gathered, sourceRays, sources,
        passed, sums, open, openBefore, cuts, cutTotals, shares, emitted, counts;
    VkDeviceAddress gatheredBefore, rayLights, sourceLights, emitterHits, pathLights, componentSums, componentEmitted;
    uint32_t blockCount, texelCount;
};

constexpr std::size_t kMostRays = DeviceGather::kMostBlocks * kPatternBlock;

} // namespace

/// Buffers of one call. The lists that the processor writes and reads are in its memory, and the device reaches them
/// there: each of their bytes is used once.
struct GpuGather::Workspace {
    Workspace(gpu::Device& device, const GatherTables& tables, bool tinted)
        : map(device, tables.paths.surfaces().geometry(), kMostBlocks, tables.cache.layout().hitIndexOfTriangle),
          requests(device, kMostBlocks * sizeof(Texel), gpu::kAddressed, gpu::MemoryUse::Upload),
          texels(device, kMostBlocks * sizeof(GpuGatherTexel), gpu::kAddressed, gpu::MemoryUse::Device),
          points(device, kMostBlocks * kPatternBlock * sizeof(GpuPoint), gpu::kAddressed, gpu::MemoryUse::Device),
          blocks(device, kMostBlocks * sizeof(Block), gpu::kAddressed, gpu::MemoryUse::Upload),
          lists(device, sizeof(Lists), gpu::kAddressed, gpu::MemoryUse::Upload),
          rays(device, kMostRays * sizeof(GpuRay), gpu::kAddressed, gpu::MemoryUse::Device),
          hits(device, kMostRays * sizeof(GpuHit), gpu::kAddressed, gpu::MemoryUse::Device),
          gathered(device, kMostRays * sizeof(vec3), gpu::kAddressed, gpu::MemoryUse::Device),
          sourceRays(device, kMostRays * sizeof(GpuRay), gpu::kAddressed, gpu::MemoryUse::Device),
          sources(device, kMostRays * sizeof(vec3), gpu::kAddressed, gpu::MemoryUse::Device),
          passed(device, kMostRays * (tinted ? sizeof(vec3) : sizeof(float)), gpu::kAddressed, gpu::MemoryUse::Device),
          sums(device, kMostBlocks * sizeof(Sums), gpu::kAddressed, gpu::MemoryUse::Readback),
          open(device, kMostRays * sizeof(GpuOpen), gpu::kAddressed, gpu::MemoryUse::Device),
          openBefore(device, kMostRays / kGroupSize * sizeof(uint32_t), gpu::kAddressed, gpu::MemoryUse::Readback),
          counts(device, kCounters * sizeof(uint32_t), gpu::kAddressed, gpu::MemoryUse::Readback),
          components(device, tables.paths.light())
    {
        const SceneLight& light = tables.paths.light();
        if (!light.samplesEmission()) return;
        const auto make = [&](std::size_t bytes, gpu::MemoryUse use) {
            return gpu::Buffer(device, kMostBlocks * bytes, gpu::kAddressed, use);
        };
        if (const std::size_t cutNodes = light.emitters().tree().cutNodes(); cutNodes > 0) {
            cuts = make(cutNodes * sizeof(GpuCutNode), gpu::MemoryUse::Device);
            cutTotals = make(sizeof(float), gpu::MemoryUse::Device);
        }
        shares = make(sizeof(GpuEmitterShare), gpu::MemoryUse::Device);
        emitted = make(sizeof(Halves), gpu::MemoryUse::Readback);
    }
    TexelLists map;
    gpu::Buffer requests, texels, points, blocks, lists, rays, hits, gathered, sourceRays, sources, passed, sums, open,
        openBefore, counts;
    ComponentLists components;
    gpu::Buffer cuts, cutTotals, shares, emitted; ///< empty where they are not needed
};

GpuGather::~GpuGather() = default;

GpuGather::GpuGather(BakeDevice& device, const DeviceScene& scene, const PathTables& pathTables,
                     const GatherTables& tables)
    : device_(device), scene_(scene), paths_(device.paths(scene.tinted())),
      emitters_(tables.paths.light().samplesEmission() ? &device.emitters() : nullptr),
      components_(tables.paths.light().components() > 0 ? &device.components() : nullptr),
      componentCount_(std::size_t(tables.paths.light().components())),
      anyEmitters_(!tables.paths.light().emitters().empty())
{
    gpu::Device& on = device.device();
    const auto keep = [&](const auto& list) {
        buffers_.push_back(bufferOf(on, std::span(std::as_const(list))));
        return buffers_.back().address();
    };
    const PatchLayout& layout = tables.cache.layout();
    const StratifiedPattern::Tables pattern = tables.pattern.tables();
    const SourceClusters& clusters = tables.guides.clusters();
    GatherAddresses t = pathTables.ofScene();
    t.pattern = keep(pattern.points);
    t.radii = keep(pattern.radii);
    t.angles = keep(pattern.angles);
    t.surfaces = keep(layout.surfaces);
    t.elements = keep(layout.elements);
    t.patches = keep(tables.cache.patches());
    t.components = keep(tables.cache.components().patches);
    t.guideOfPatch = keep(tables.guides.guideOfPatch());
    std::vector<uint32_t> sources;
    for (const Guide& guide : tables.guides.guides())
        sources.push_back(uint32_t(sourceSamplesOf(guide, componentCount_ > 0)));
    anySources_ = std::any_of(sources.begin(), sources.end(), [](uint32_t samples) { return samples > 0; });
    t.sourcesOfGuide = keep(sources);
    t.guides = keep(tables.guides.guides());
    t.entries = keep(tables.guides.entries());
    t.cumulative = keep(tables.guides.cumulative());
    t.clusters = keep(clusters.clusters());
    t.triangles = keep(clusters.triangles());
    std::vector<uint32_t> masks;
    for (const SourceClusters::SourceTriangle& source : clusters.triangles())
        masks.push_back(scene.maskedOf(source.face.hitIndex));
    t.sourceMasks = keep(masks);
    t.bins = keep(clusters.bins());
    t.members = keep(clusters.members());
    t.paths = pathTables.forPaths(tables.bounces, &tables.cache, buffers_);
    t.all.seed = tables.seed;
    t.all.sourceSeed = tables.seed ^ kSourceSeed;
    t.all.emitterSeed = tables.seed ^ kEmitterSeed;
    t.all.rouletteSeed = tables.seed ^ kRouletteSeed;
    t.all.chartPatches = layout.chartPatches;
    t.all.patchShift = layout.patchShift;
    t.all.memberCount = uint32_t(clusters.members().size());
    // Without sources there are no guides.
    t.all.guidedPatches = tables.guides.empty() ? 0 : uint32_t(tables.guides.guideOfPatch().size());
    tables_ = bufferOf(on, std::span<const GatherAddresses>(&t, 1));
    workspace_ = std::make_unique<Workspace>(on, tables, scene.tinted());
}

Status GpuGather::gather(const TexelMap& map, const Batch& batch, const Light& out, uint64_t& rays) const
{
    const std::size_t texels = batch.texels.size();
    const std::size_t blocks = batch.blocks.size();
    if (blocks == 0) return {};
    const TexelLists::Copy mapTexels =
        workspace_->map.copyOf(map, texels, [&](std::size_t i) { return batch.texels[i].texel; });
    const std::lock_guard turn(mutex_);
    const Workspace& w = *workspace_;
    try {
        setLists(mapTexels, batch);
        traceRays(texels, blocks);
        finishRays(texels, blocks, placesOfOpenRays(blocks));
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    const auto read = [](const auto& list, const gpu::Buffer& from) {
        if (!list.empty()) std::memcpy(list.data(), from.mapped(), list.size_bytes());
    };
    read(out.gathered, w.sums);
    read(out.emitted, w.emitted);
    read(out.gatheredOf, w.components.sumsRead);
    read(out.emittedOf, w.components.emittedRead);
    uint32_t others = 0;
    std::memcpy(&others, w.counts.mapped() + kRayCount * sizeof(others), sizeof(others));
    rays += blocks * kPatternBlock + others;
    return {};
}

/// Copies a call's lists to the workspace.
void GpuGather::setLists(const TexelLists::Copy& mapTexels, const Batch& batch) const
{
    Workspace& w = *workspace_;
    const ComponentLists& c = w.components;
    const auto write = [](const gpu::Buffer& to, const auto& list) {
        std::memcpy(to.mapped(), list.data(), list.size_bytes());
    };
    w.map.set(mapTexels);
    write(w.requests, batch.texels);
    write(w.blocks, batch.blocks);
    if (componentCount_ > 0) write(c.before, batch.ofComponents);
    std::memset(w.counts.mapped(), 0, w.counts.size());
    const Lists lists{w.map.texels(),
                      w.map.fragments(),
                      w.requests.address(),
                      w.texels.address(),
                      w.points.address(),
                      w.blocks.address(),
                      w.rays.address(),
                      w.hits.address(),
                      w.gathered.address(),
                      w.sourceRays.address(),
                      w.sources.address(),
                      w.passed.address(),
                      w.sums.address(),
                      w.open.address(),
                      w.openBefore.address(),
                      w.cuts.address(),
                      w.cutTotals.address(),
                      w.shares.address(),
                      w.emitted.address(),
                      w.counts.address(),
                      c.before.address(),
                      c.rayLights.address(),
                      c.sourceLights.address(),
                      c.emitterHits.address(),
                      c.pathLights.address(),
                      c.sums.address(),
                      c.emitted.address(),
                      uint32_t(batch.blocks.size()),
                      uint32_t(batch.texels.size())};
    std::memcpy(w.lists.mapped(), &lists, sizeof(lists));
}

/// Finds how many open rays come before those of each group. Returns how many there are.
uint32_t GpuGather::placesOfOpenRays(std::size_t blocks) const
{
    const gpu::Buffer& list = workspace_->openBefore;
    std::vector<uint32_t> groups(raysOfChunks(uint32_t(blocks), kPatternBlock) / kGroupSize);
    const std::span<uint32_t> bytes(groups);
    std::memcpy(groups.data(), list.mapped(), bytes.size_bytes());
    const uint32_t last = groups.back();
    std::exclusive_scan(groups.begin(), groups.end(), groups.begin(), 0u);
    std::memcpy(list.mapped(), groups.data(), bytes.size_bytes());
    return groups.back() + last;
}

/// Traces the rays of all blocks. Those whose light is unknown are in a list afterwards.
void GpuGather::traceRays(std::size_t texels, std::size_t blocks) const
{
    const Workspace& w = *workspace_;
    const GatherPush push{tables_.address(), w.lists.address()};
    const std::span<const std::byte> bytes = gpu::bytesOf(push);
    const uint32_t count = raysOfChunks(uint32_t(blocks), kPatternBlock);
    device_.device().execute([&](VkCommandBuffer commands) {
        device_.gatherPoints().run(commands, bytes, texels * kPatternBlock, kGroupSize);
        device_.gatherRays().run(commands, bytes, count, kGroupSize);
        device_.nearest(commands, {scene_.address(), w.rays.address(), w.hits.address(), 0, scene_.tinted()}, count);
        device_.gatherLight().run(commands, bytes, count, kGroupSize);
        if (anySources_) {
            device_.gatherSources().run(commands, bytes, count, kGroupSize);
            device_.transmittance(commands, sourcePush(), count);
        }
        gpu::fullBarrier(device_.device(), commands);
    });
}

/// Traces the paths of `open` rays, and adds all light by block. Then it samples emitters and the sky.
void GpuGather::finishRays(std::size_t texels, std::size_t blocks, uint32_t open) const
{
    const Workspace& w = *workspace_;
    const GatherPush push{tables_.address(), w.lists.address()};
    const std::span<const std::byte> bytes = gpu::bytesOf(push);
    device_.device().execute([&](VkCommandBuffer commands) {
        tracePaths(commands, blocks, open);
        if (anyEmitters_) {
            emitters_->cuts.run(commands, bytes, texels, kGroupSize);
            emitters_->hits.run(commands, bytes, raysOfChunks(uint32_t(blocks), kPatternBlock), kGroupSize);
        }
        device_.gatherSums().run(commands, bytes, blocks, kGroupSize);
        if (components_ != nullptr) components_->gathered.run(commands, bytes, blocks * componentCount_, kGroupSize);
        if (emitters_ != nullptr) sampleEmitters(commands, texels, blocks);
        if (components_ != nullptr) copyComponents(commands, blocks);
        gpu::fullBarrier(device_.device(), commands);
    });
}

/// Of rays to sources and emitters.
TracePush GpuGather::sourcePush() const
{
    return {scene_.address(), workspace_->sourceRays.address(), workspace_->passed.address(), 0, scene_.tinted()};
}

/// Traces the paths of `open` rays. Of components their light is added up launch by launch.
void GpuGather::tracePaths(VkCommandBuffer commands, std::size_t blocks, uint32_t open) const
{
    const Workspace& w = *workspace_;
    const auto most = uint32_t(w.components.mostPaths);
    for (uint32_t first = 0; first == 0 || first < open; first += most) {
        const uint32_t count = std::min(open - first, most);
        const TablesPush push{scene_.address(), tables_.address(), w.lists.address(), 0, first};
        paths_.run(commands, gpu::bytesOf(push), count);
        if (components_ == nullptr) continue;
        const OpenRangePush range{tables_.address(), w.lists.address(), first, first + count};
        components_->paths.run(commands, gpu::bytesOf(range), blocks * componentCount_, kGroupSize);
    }
}

/// How many samples a block takes follows from the light that its texel has gathered.
void GpuGather::sampleEmitters(VkCommandBuffer commands, std::size_t texels, std::size_t blocks) const
{
    const Workspace& w = *workspace_;
    const GatherPush push{tables_.address(), w.lists.address()};
    const std::span<const std::byte> bytes = gpu::bytesOf(push);
    const uint32_t count = raysOfChunks(uint32_t(blocks), kPatternBlock);
    emitters_->shares.run(commands, bytes, texels, kGroupSize);
    emitters_->rays.run(commands, bytes, count, kGroupSize);
    device_.transmittance(commands, sourcePush(), count);
    emitters_->sums.run(commands, bytes, blocks, kGroupSize);
    if (components_ != nullptr) components_->emitted.run(commands, bytes, blocks * componentCount_, kGroupSize);
}

/// What the processor reads of components.
void GpuGather::copyComponents(VkCommandBuffer commands, std::size_t blocks) const
{
    const ComponentLists& c = workspace_->components;
    const std::size_t bytes = blocks * componentCount_ * sizeof(Halves);
    gpu::copyBytes(device_.device(), commands, {c.sums}, {c.sumsRead}, bytes);
    if (emitters_ != nullptr) gpu::copyBytes(device_.device(), commands, {c.emitted}, {c.emittedRead}, bytes);
}

} // namespace halflight
