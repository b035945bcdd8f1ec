#include "bake_gpu/radiosity/radiosity.h"

#include "bake_gpu/radiosity/radiosity_pipelines.h"
#include "transport/radiosity/form_factors.h"
#include "transport/radiosity/split_patches.h"

#include "halflight/base/parallel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace halflight {
namespace {

using namespace shading;

static_assert(sizeof(DeviceRadiosity::FactorRay) == sizeof(GpuFactorRay));
static_assert(sizeof(DeviceRadiosity::DirectSample) == sizeof(GpuDirectSample));
static_assert(sizeof(DeviceRadiosity::LightPart) == sizeof(GpuLightPart));
static_assert(sizeof(RimPoint) == sizeof(GpuRimPoint) && sizeof(RimPoints) == sizeof(GpuRadiosityPass::rim));
static_assert(DeviceRadiosity::kNearBit == kFactorNear && DeviceRadiosity::kLeaves == kFactorLeaves &&
              DeviceRadiosity::kOpen == kFactorOpen);
static_assert(uint32_t(PassKind::Fronts) == kFrontsPass && uint32_t(PassKind::Elements) == kElementsPass &&
              uint32_t(PassKind::Backs) == kBacksPass && uint32_t(PassKind::BackElements) == kBackElementsPass &&
              uint32_t(PassKind::Triangles) == kTrianglesPass);

/// RadiosityLists in shaders/bake/radiosity/radiosity.glsl.
struct RadiosityLists {
    VkDeviceAddress mapTexels, fragments, requests, items, points, states, elements, widths, rays, tints, direct, found,
        counts, emitters, parts;
    uint32_t itemCount;
    GpuRadiosityPass pass;
};
struct RadiosityPush {
    VkDeviceAddress tables, lists;
};

/// Most rays and light samples that an item takes in any pass.
FormFactorEffort mostEffort(const RadiosityInput& input, int patchShift)
{
    FormFactorEffort most{0, 0};
    for (const PassKind kind : {PassKind::Fronts, PassKind::Elements}) {
        const FormFactorEffort effort = effortOf(input.settings, kind, patchShift);
        most.rays = std::max(most.rays, effort.blocks() * effort.strata());
        most.direct = std::max(most.direct, effort.direct);
    }
    return most;
}

/// Items of a call whose light samples have parts: these take 64 MiB at most, unless one range takes more.
std::size_t mostItemsOf(int direct, std::size_t parts)
{
    constexpr std::size_t kMostBytes = std::size_t(64) << 20;
    if (parts == 0) return DeviceRadiosity::kMostItems;
    const std::size_t bytes = kRangeItems * std::size_t(direct) * parts * sizeof(GpuLightPart);
    return std::clamp<std::size_t>(kMostBytes / bytes * kRangeItems, kRangeItems, DeviceRadiosity::kMostItems);
}

/// Widths of texels on triangles that rays hit; of triangles without texels, their longest edge.
std::vector<float> widthsOf(const RayTracer& surfaces, const PatchLayout& layout)
{
    std::vector<float> widths(surfaces.hitTriangleCount());
    forEachIndex(widths.size(), [&](std::size_t i) {
        const uint32_t triangle = surfaces.triangleAt(uint32_t(i));
        const PatchLayout::Surface& surface = layout.surfaces[i];
        const bool isPatch = surface.hasPatches != 0 && surface.firstPatch >= 2 * layout.chartPatches;
        widths[i] = isPatch ? longestEdgeOf(surfaces.geometry(), triangle) : surfaces.geometry().texelMeters(triangle);
    });
    return widths;
}

} // namespace

/// Buffers of one call. What the processor writes is in its memory, and the device reaches it there. What it reads is
/// copied: single words that shaders write to its memory would take longer.
struct GpuRadiosity::Workspace {
    Workspace(gpu::Device& device, const RadiosityInput& input, const PatchLayout& layout, std::size_t items,
              bool tinted)
        : texels(device, input.paths.surfaces().geometry(), items, layout.hitIndexOfTriangle),
          requests(device, items * sizeof(GpuRadiosityItem), gpu::kAddressed, gpu::MemoryUse::Upload),
          lists(device, sizeof(RadiosityLists), gpu::kAddressed, gpu::MemoryUse::Upload),
          listsOnDevice(device, sizeof(RadiosityLists), gpu::kAddressed, gpu::MemoryUse::Device),
          items(device, items * sizeof(GpuPatchItem), gpu::kAddressed, gpu::MemoryUse::Device),
          points(device, items * kPatchPoints * sizeof(GpuPatchPoint), gpu::kAddressed, gpu::MemoryUse::Device)
    {
        const FormFactorEffort most = mostEffort(input, layout.patchShift);
        const std::size_t rayBytes = items * std::size_t(most.rays) * sizeof(FactorRay);
        const std::size_t directBytes = items * std::size_t(most.direct) * sizeof(DirectSample);
        rays = {device, rayBytes, gpu::kAddressed, gpu::MemoryUse::Device};
        direct = {device, directBytes, gpu::kAddressed, gpu::MemoryUse::Device};
        addRead(device, rayBytes, &ReadBack::rays);
        addRead(device, directBytes, &ReadBack::direct);
        if (tinted) {
            const std::size_t tintBytes = items * std::size_t(most.rays) * sizeof(vec3);
            tints = {device, tintBytes, gpu::kAddressed, gpu::MemoryUse::Device};
            addRead(device, tintBytes, &ReadBack::tints);
        }
        if (const std::size_t ofSample = partsOf(input.paths.light()); ofSample > 0)
            addParts(device, input, layout, items, ofSample, items * std::size_t(most.rays));
    }
    /// What components need.
    void addParts(gpu::Device& device, const RadiosityInput& input, const PatchLayout& layout, std::size_t items,
                  std::size_t ofSample, std::size_t mostRays)
    {
        std::size_t bytes = 0;
        for (const PassKind kind : {PassKind::Fronts, PassKind::Elements}) {
            const int direct = effortOf(input.settings, kind, layout.patchShift).direct;
            const std::size_t most = std::min(items, mostItemsOf(direct, ofSample));
            bytes = std::max(bytes, most * std::size_t(direct) * ofSample * sizeof(LightPart));
        }
        parts = {device, bytes, gpu::kAddressed, gpu::MemoryUse::Device};
        addRead(device, bytes, &ReadBack::parts);
        const std::size_t words = mostRays * sizeof(uint32_t);
        emitters = {device, words, gpu::kAddressed, gpu::MemoryUse::Device};
        addRead(device, words, &ReadBack::emitters);
    }
    /// What the processor reads of a call. Calls take turns with two of them.
    struct ReadBack {
        gpu::Buffer rays, direct;
        gpu::Buffer tints;           ///< empty where no glass has a colour
        gpu::Buffer emitters, parts; ///< empty where light is estimated as one
    };
    void addRead(gpu::Device& device, std::size_t bytes, gpu::Buffer ReadBack::*buffer)
    {
        for (ReadBack& r : read)
            r.*buffer = {device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback};
    }
    const ReadBack& readNow() const { return read[calls % read.size()]; }
    template<typename T> std::span<const T> readAs(gpu::Buffer ReadBack::*buffer, std::size_t count) const
    {
        return {reinterpret_cast<const T*>((readNow().*buffer).mapped()), count};
    }
    TexelLists texels;
    gpu::Buffer requests, lists, listsOnDevice, items, points;
    gpu::Buffer rays, direct;
    gpu::Buffer tints;           ///< empty where no glass has a colour
    gpu::Buffer emitters, parts; ///< empty where light is estimated as one
    std::array<ReadBack, 2> read;
    std::size_t calls = 0; ///< of gather()
};

GpuRadiosity::~GpuRadiosity() = default;

GpuRadiosity::GpuRadiosity(BakeDevice& device, const DeviceScene& scene, const PathTables& pathTables,
                           const RadiosityInput& input, const PatchLayout& layout)
    : device_(device), scene_(scene), input_(input), pipelines_(device.radiosity(scene.tinted())),
      transfer_(device.device())
{
    gpu::Device& on = device.device();
    const auto keep = [&](const auto& list) {
        buffers_.push_back(bufferOf(on, list));
        return buffers_.back().address();
    };
    const StratifiedPattern::Tables pattern = input.pattern.tables();
    GatherAddresses t = pathTables.ofScene();
    t.pattern = keep(pattern.points);
    t.radii = keep(pattern.radii);
    t.angles = keep(pattern.angles);
    t.surfaces = keep(layout.surfaces);
    t.paths = pathTables.forPaths(0, nullptr, buffers_);
    t.all.chartPatches = layout.chartPatches;
    t.all.patchShift = layout.patchShift;
    widths_ = keep(widthsOf(input.paths.surfaces(), layout));
    tables_ = bufferOf(on, std::span<const GatherAddresses>(&t, 1));
    const std::size_t triangles = 2 * layout.hitIndexOfTriangle.size();
    workspace_ = std::make_unique<Workspace>(
        on, input, layout, std::min(std::max(input.map.texels.size(), triangles), kMostItems), scene.tinted());
}

Status GpuRadiosity::begin(const PatchPass& pass)
{
    try {
        setPass(pass);
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    return {};
}

void GpuRadiosity::setPass(const PatchPass& pass)
{
    gpu::Device& on = device_.device();
    const PatchLayout& layout = pass.layout();
    const std::vector<PatchState>& state = pass.patches().state;
    const FormFactorEffort effort = effortOf(pass);
    pass_ = &pass;
    constants_ = {uint32_t(pass.kind()),
                  seedOfFactors(pass),
                  layout.patchCount(),
                  uint32_t(kRangeItems),
                  effort.blocks(),
                  effort.strata(),
                  effort.direct,
                  uint32_t(partsOf(input_.paths.light())),
                  kLineLift,
                  {}};
    std::memcpy(constants_.rim, rimPoints().data(), sizeof(constants_.rim));
    const auto grow = [&](gpu::Buffer& buffer, std::size_t bytes, gpu::MemoryUse use) {
        if (buffer.size() >= bytes) return false;
        buffer = {};
        buffer = {on, bytes, gpu::kAddressed, use};
        return true;
    };
    PassBuffers& to = passBuffers_;
    const std::size_t words = (state.size() + 31) / 32 + 1;
    grow(to.states, (state.size() + 3) / 4 * 4, gpu::MemoryUse::Device);
    grow(to.elements, layout.elements.size() * sizeof(uint32_t), gpu::MemoryUse::Device);
    grow(to.tally, words * sizeof(uint32_t), gpu::MemoryUse::Device);
    grow(to.tallied, words * sizeof(uint32_t), gpu::MemoryUse::Readback);
    if (grow(to.noTally, words * sizeof(uint32_t), gpu::MemoryUse::Upload))
        std::memset(to.noTally.mapped(), 0, to.noTally.size());
    transfer_.upload<uint8_t>(to.states, state.size(), [&](std::size_t i) {
        const PatchState s = state[i];
        return uint8_t((s.occluded ? kOccludedState : 0) | (s.hit ? kHitState : 0) |
                       (s.texelWide ? kTexelWideState : 0));
    });
    transfer_.upload(to.elements, std::span(layout.elements));
}

/// Writes the items of a call.
void GpuRadiosity::setItems(std::span<const uint32_t> items)
{
    Workspace& w = *workspace_;
    const bool triangles = pass_->kind() == PassKind::Triangles;
    auto* const requests = reinterpret_cast<GpuRadiosityItem*>(w.requests.mapped());
    const FormFactorEffort effort = effortOf(*pass_);
    forEachIndex(items.size(), [&](std::size_t i) {
        if (!triangles) {
            requests[i] = {kNone, 0, effort.groupOf(items[i / kLanes * kLanes])};
            return;
        }
        const TexelGroup::Side side = pass_->sideOf(items[i]);
        FaceId face;
        const bool hit = pass_->layout().faceOf(side.triangle, side.back, face);
        requests[i] = {hit ? face.hitIndex | (face.back != 0 ? kBackBit : 0) : kNone, TexelGroup::idOf(side), 0};
    });
    if (!triangles) w.texels.set(input_.map, items.size(), [&](std::size_t i) { return items[i]; });
    const PassBuffers& pass = passBuffers_;
    const RadiosityLists lists{w.texels.texels(),
                               w.texels.fragments(),
                               w.requests.address(),
                               w.items.address(),
                               w.points.address(),
                               pass.states.address(),
                               pass.elements.address(),
                               widths_,
                               w.rays.address(),
                               w.tints.address(),
                               w.direct.address(),
                               pass.tally.address() + sizeof(uint32_t),
                               pass.tally.address(),
                               w.emitters.address(),
                               w.parts.address(),
                               uint32_t(items.size()),
                               constants_};
    std::memcpy(w.lists.mapped(), &lists, sizeof(lists));
}

/// Makes the points of a call's items, runs launch(commands, push constants), and then copy(commands).
template<typename Launch, typename Copy>
void GpuRadiosity::run(std::size_t items, const Launch& launch, const Copy& copy)
{
    gpu::Device& on = device_.device();
    const PassBuffers& pass = passBuffers_;
    const Workspace& w = *workspace_;
    const RadiosityPush push{tables_.address(), w.listsOnDevice.address()};
    const TablesPush tracePush{scene_.address(), tables_.address(), w.listsOnDevice.address()};
    on.execute([&](VkCommandBuffer commands) {
        gpu::copyBytes(on, commands, {w.lists}, {w.listsOnDevice}, sizeof(RadiosityLists));
        gpu::copyBytes(on, commands, {pass.noTally}, {pass.tally}, pass.tally.size());
        pipelines_.points.run(commands, gpu::bytesOf(push), items * kPatchPoints, kGroupSize);
        launch(commands, gpu::bytesOf(tracePush));
        gpu::copyBytes(on, commands, {pass.tally}, {pass.tallied}, pass.tally.size());
        copy(commands);
        gpu::fullBarrier(on, commands);
    });
}

std::span<const uint32_t> GpuRadiosity::tallied() const
{
    return {reinterpret_cast<const uint32_t*>(passBuffers_.tallied.mapped()),
            (pass_->patches().state.size() + 31) / 32 + 1};
}

Status GpuRadiosity::findOccluded(std::span<const uint32_t> items, std::vector<PatchId>& found, uint64_t& rays)
{
    try {
        setItems(items);
        const auto launch = [&](VkCommandBuffer commands, std::span<const std::byte> push) {
            pipelines_.occluders.run(commands, push, raysOfChunks(uint32_t(items.size()), kOccluderTargets));
        };
        run(items.size(), launch, [](VkCommandBuffer) {});
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    rays += tallied()[0];
    const std::span<const uint32_t> words = tallied().subspan(1);
    for (std::size_t i = 0; i < words.size(); ++i) {
        for (uint32_t bits = words[i]; bits != 0; bits &= bits - 1)
            found.push_back(PatchId(32 * i) + PatchId(std::countr_zero(bits)));
    }
    return {};
}

std::size_t GpuRadiosity::mostItems() const
{
    return mostItemsOf(constants_.direct, constants_.parts);
}

DeviceRadiosity::Traced GpuRadiosity::tracedOf(std::size_t items) const
{
    using ReadBack = Workspace::ReadBack;
    const Workspace& w = *workspace_;
    const std::size_t rays = items * std::size_t(constants_.blocks * constants_.strata);
    const std::size_t direct = items * std::size_t(constants_.direct);
    Traced traced{
        w.readAs<FactorRay>(&ReadBack::rays, rays), w.readAs<DirectSample>(&ReadBack::direct, direct), {}, {}, {}};
    if (scene_.tinted()) traced.tints = w.readAs<vec3>(&ReadBack::tints, rays);
    if (constants_.parts == 0) return traced;
    traced.emitters = w.readAs<uint32_t>(&ReadBack::emitters, rays);
    traced.parts = w.readAs<LightPart>(&ReadBack::parts, direct * constants_.parts);
    return traced;
}

Status GpuRadiosity::gather(std::span<const uint32_t> items, Traced& traced, uint64_t& rays)
{
    const auto count = uint32_t(items.size());
    const auto raysOfItem = uint32_t(constants_.blocks * constants_.strata);
    const auto directOfItem = uint32_t(constants_.direct);
    Workspace& w = *workspace_;
    ++w.calls;
    traced = tracedOf(items.size());
    try {
        setItems(items);
        const auto launch = [&](VkCommandBuffer commands, std::span<const std::byte> push) {
            pipelines_.factors.run(commands, push, raysOfChunks(count, raysOfItem));
            pipelines_.direct.run(commands, push, raysOfChunks(count, directOfItem));
        };
        run(items.size(), launch, [&](VkCommandBuffer commands) {
            const auto copy = [&](const gpu::Buffer& from, const gpu::Buffer& to, const auto& list) {
                if (!list.empty()) gpu::copyBytes(device_.device(), commands, {from}, {to}, list.size_bytes());
            };
            const Workspace::ReadBack& read = w.readNow();
            copy(w.rays, read.rays, traced.rays);
            copy(w.direct, read.direct, traced.direct);
            copy(w.tints, read.tints, traced.tints);
            copy(w.emitters, read.emitters, traced.emitters);
            copy(w.parts, read.parts, traced.parts);
        });
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    const bool all = pass_->kind() != PassKind::Fronts && pass_->kind() != PassKind::Elements;
    const auto active = std::count_if(items.begin(), items.end(),
                                      [&](uint32_t item) { return all || input_.map.texels[item].validPoints != 0; });
    rays += tallied()[0] + uint64_t(active) * raysOfItem;
    return {};
}

} // namespace halflight
