#include "bake_gpu/paths/paths.h"

#include "bake_gpu/gather/gather_layout.h"
#include "bake_gpu/paths/start_layout.h"

#include <cassert>
#include <cstring>

namespace halflight {
namespace {

using namespace shading;

static_assert(sizeof(DevicePaths::Point) == sizeof(GpuPoint) && sizeof(DevicePaths::Item) == sizeof(GpuPathItem));
static_assert(sizeof(DevicePaths::Arrival) == sizeof(GpuArrival));
static_assert(sizeof(DevicePaths::Emission) == sizeof(GpuEmission));

/// PathStarts in shaders/bake/paths/starts.glsl.
struct StartLists {
    VkDeviceAddress points, items, arrivals, emissions, components;
    GpuPathCall all;
};

/// Calls that run at one time: the device traces one while threads make and read the others.
constexpr std::size_t kWorkspaces = 3;

} // namespace

/// Buffers of one call. The device reads points in the processor's memory, each of them a few times. Results are copied
/// there, because single writes to it are slow.
struct GpuPaths::Workspace {
    Workspace(gpu::Device& device, bool samplesEmission, int componentCount)
        : points(device, std::size_t(kMostItems) * kMostPointsOfItem * sizeof(Point), gpu::kAddressed,
                 gpu::MemoryUse::Upload),
          items(device, kMostItems * sizeof(Item), gpu::kAddressed, gpu::MemoryUse::Upload),
          lists(device, sizeof(StartLists), gpu::kAddressed, gpu::MemoryUse::Upload),
          arrivals(device, kMostPaths * sizeof(Arrival), gpu::kAddressed, gpu::MemoryUse::Device),
          arrived(device, kMostPaths * sizeof(Arrival), VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback)
    {
        const std::size_t bytes = std::size_t(mostPaths(componentCount)) * std::size_t(componentCount) * sizeof(vec3);
        if (bytes > 0) {
            components = {device, bytes, gpu::kAddressed, gpu::MemoryUse::Device};
            componentsRead = {device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback};
        }
        if (!samplesEmission) return;
        emissions = {device, kMostPaths * sizeof(Emission), gpu::kAddressed, gpu::MemoryUse::Device};
        emitted = {device, kMostPaths * sizeof(Emission), VK_BUFFER_USAGE_TRANSFER_DST_BIT, gpu::MemoryUse::Readback};
    }
    gpu::Buffer points, items, lists, arrivals, arrived;
    gpu::Buffer emissions, emitted;         ///< empty where nothing is sampled
    gpu::Buffer components, componentsRead; ///< empty where light is estimated as one
};

/// Takes a workspace as long as it lives: one that is free, or else a new one, or else it waits. Throws gpu::Failure.
class GpuPaths::Turn {
public:
    explicit Turn(const GpuPaths& paths) : paths_(paths)
    {
        std::unique_lock lock(paths.mutex_);
        if (paths.free_.empty() && paths.workspaces_.size() < kWorkspaces) {
            paths.workspaces_.push_back(
                std::make_unique<Workspace>(paths.device_.device(), paths.samplesEmission_, paths.components_));
            paths.free_.push_back(paths.workspaces_.back().get());
        }
        paths.freed_.wait(lock, [&] { return !paths.free_.empty(); });
        workspace_ = paths.free_.back();
        paths.free_.pop_back();
    }
    ~Turn()
    {
        {
            const std::lock_guard lock(paths_.mutex_);
            paths_.free_.push_back(workspace_);
        }
        paths_.freed_.notify_one();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    [[nodiscard]] const Workspace& workspace() const { return *workspace_; }

private:
    const GpuPaths& paths_;
    Workspace* workspace_;
};

GpuPaths::~GpuPaths() = default;

GpuPaths::GpuPaths(BakeDevice& device, const DeviceScene& scene, const PathTables& pathTables, const PathTracer& paths,
                   int bounces)
    : device_(device), scene_(scene), pipeline_(device.paths(scene.tinted())),
      samplesEmission_(paths.light().samplesEmission()), components_(paths.light().components())
{
    GatherAddresses tables = pathTables.ofScene();
    tables.paths = pathTables.forPaths(bounces, nullptr, buffers_);
    tables_ = bufferOf(device.device(), std::span<const GatherAddresses>(&tables, 1));
}

Status GpuPaths::trace(const Batch& batch, Use use) const
{
    const std::size_t count = batch.items.size() * batch.pathsOfItem;
    assert(batch.items.size() <= kMostItems && count <= mostPaths(batch.byComponent ? components_ : 0));
    assert(batch.points.size() <= batch.items.size() * kMostPointsOfItem);
    if (count == 0) return {};
    try {
        const Turn turn(*this);
        const Workspace& w = turn.workspace();
        run(w, batch);
        Light light{{reinterpret_cast<const Arrival*>(w.arrived.mapped()), count}, {}, {}};
        if (samplesEmission_) light.emissions = {reinterpret_cast<const Emission*>(w.emitted.mapped()), count};
        if (batch.byComponent)
            light.components = {reinterpret_cast<const vec3*>(w.componentsRead.mapped()),
                                count * std::size_t(components_)};
        use(light);
    } catch (const gpu::Failure& failure) {
        return Error{ErrorCode::DeviceFailed, failure.what()};
    }
    return {};
}

/// Traces the paths of a batch; what they bring is in the processor's memory afterwards.
void GpuPaths::run(const Workspace& w, const Batch& batch) const
{
    const std::size_t count = batch.items.size() * batch.pathsOfItem;
    const StartLists lists{
        w.points.address(),
        w.items.address(),
        w.arrivals.address(),
        w.emissions.address(),
        w.components.address(),
        {batch.seed, uint32_t(batch.items.size()), batch.firstPath, batch.pathsOfItem, batch.byComponent ? 1u : 0u}};
    std::memcpy(w.points.mapped(), batch.points.data(), batch.points.size_bytes());
    std::memcpy(w.items.mapped(), batch.items.data(), batch.items.size_bytes());
    std::memcpy(w.lists.mapped(), &lists, sizeof(lists));
    gpu::Device& device = device_.device();
    device.execute([&](VkCommandBuffer commands) {
        const TablesPush push{scene_.address(), tables_.address(), w.lists.address(), 1};
        pipeline_.run(commands, gpu::bytesOf(push), raysOfChunks(uint32_t(batch.items.size()), batch.pathsOfItem));
        gpu::copyBytes(device, commands, {w.arrivals}, {w.arrived}, count * sizeof(Arrival));
        if (samplesEmission_) gpu::copyBytes(device, commands, {w.emissions}, {w.emitted}, count * sizeof(Emission));
        if (batch.byComponent)
            gpu::copyBytes(device, commands, {w.components}, {w.componentsRead},
                           count * std::size_t(components_) * sizeof(vec3));
        gpu::fullBarrier(device, commands);
    });
}

} // namespace halflight
