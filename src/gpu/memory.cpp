#include "gpu/memory.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

namespace halflight::gpu {
namespace {

constexpr VkDeviceSize kBlockBytes = VkDeviceSize(64) << 20;

VkDeviceSize alignUp(VkDeviceSize value, VkDeviceSize alignment)
{
    return (value + alignment - 1) / alignment * alignment;
}

/// Memory types in order of preference: those with most wanted flags first, in the driver's order among equals.
std::vector<uint32_t> suitableTypes(const VkPhysicalDeviceMemoryProperties& properties, uint32_t typeBits,
                                    MemoryUse use)
{
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags required = use == MemoryUse::Device ? 0 : host;
    const VkMemoryPropertyFlags wanted = use == MemoryUse::Device     ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
                                         : use == MemoryUse::Readback ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT
                                                                      : 0;
    const VkMemoryPropertyFlags excluded = VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT |
                                           VK_MEMORY_PROPERTY_DEVICE_COHERENT_BIT_AMD;
    std::vector<uint32_t> types;
    for (uint32_t i = 0; i < properties.memoryTypeCount; ++i) {
        const VkMemoryPropertyFlags flags = properties.memoryTypes[i].propertyFlags;
        if ((typeBits >> i & 1u) && (flags & required) == required && !(flags & excluded)) types.push_back(i);
    }
    std::stable_sort(types.begin(), types.end(), [&](uint32_t a, uint32_t b) {
        return std::popcount(properties.memoryTypes[a].propertyFlags & wanted) >
               std::popcount(properties.memoryTypes[b].propertyFlags & wanted);
    });
    return types;
}

} // namespace

Allocation& Allocation::operator=(Allocation&& other) noexcept
{
    if (this == &other) return *this;
    if (owner_) owner_->release(*this);
    owner_ = std::exchange(other.owner_, nullptr);
    block_ = other.block_;
    memory_ = std::exchange(other.memory_, VK_NULL_HANDLE);
    offset_ = other.offset_;
    size_ = other.size_;
    mapped_ = std::exchange(other.mapped_, nullptr);
    return *this;
}

Allocation::~Allocation()
{
    if (owner_) owner_->release(*this);
}

Memory::Memory(const Functions& vk, VkDevice device, const VkPhysicalDeviceMemoryProperties& properties, bool addresses,
               VkDeviceSize most, std::function<bool()> fails)
    : vk_(vk), device_(device), properties_(properties), addresses_(addresses), most_(most), fails_(std::move(fails))
{}

Memory::~Memory()
{
    for (auto& block : blocks_) destroyBlock(*block);
}

void Memory::destroyBlock(Block& block)
{
    vk_.FreeMemory(device_, block.memory, nullptr);
    if (isOnDevice(block.type)) bytes_ -= block.size;
}

bool Memory::isOnDevice(uint32_t type) const
{
    return (properties_.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0;
}

VkDeviceSize Memory::peakBytes() const
{
    const std::lock_guard lock(mutex_);
    return peakBytes_;
}

Memory::Block& Memory::addBlock(uint32_t type, VkDeviceSize size, bool image, bool dedicated)
{
    const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                          .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .pNext = addresses_ && !image ? &flags : nullptr,
                                    .allocationSize = size,
                                    .memoryTypeIndex = type};
    auto block = std::make_unique<Block>();
    check(vk_.AllocateMemory(device_, &info, nullptr, &block->memory), "allocate memory");
    if (isOnDevice(type)) peakBytes_ = std::max(peakBytes_, bytes_ += size);
    block->type = type;
    block->image = image;
    block->dedicated = dedicated;
    block->size = size;
    block->free = {{0, size}};
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    if ((properties_.memoryTypes[type].propertyFlags & host) == host && !image) {
        void* address = nullptr;
        const VkResult result = vk_.MapMemory(device_, block->memory, 0, VK_WHOLE_SIZE, 0, &address);
        if (result != VK_SUCCESS) {
            destroyBlock(*block);
            check(result, "map memory");
        }
        block->mapped = static_cast<std::byte*>(address);
    }
    blocks_.push_back(std::move(block));
    return *blocks_.back();
}

Allocation Memory::allocate(const VkMemoryRequirements& requirements, MemoryUse use, bool image)
{
    const std::lock_guard lock(mutex_);
    if (fails_ && fails_()) check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocate memory");
    const std::vector<uint32_t> types = suitableTypes(properties_, requirements.memoryTypeBits, use);
    if (types.empty()) throw Failure("the Vulkan device has no memory type for this use");

    auto carve = [&](Block& block) -> std::optional<VkDeviceSize> {
        for (std::size_t i = 0; i < block.free.size(); ++i) {
            const Range range = block.free[i];
            const VkDeviceSize begin = alignUp(range.offset, requirements.alignment);
            const VkDeviceSize end = begin + requirements.size;
            if (end > range.offset + range.size) continue;
            std::vector<Range> rest;
            if (begin > range.offset) rest.push_back({range.offset, begin - range.offset});
            if (end < range.offset + range.size) rest.push_back({end, range.offset + range.size - end});
            block.free.erase(block.free.begin() + std::ptrdiff_t(i));
            block.free.insert(block.free.begin() + std::ptrdiff_t(i), rest.begin(), rest.end());
            return begin;
        }
        return std::nullopt;
    };
    auto make = [&](Block& block, VkDeviceSize offset) {
        Allocation allocation;
        allocation.owner_ = this;
        allocation.block_ = &block;
        allocation.memory_ = block.memory;
        allocation.offset_ = offset;
        allocation.size_ = requirements.size;
        allocation.mapped_ = block.mapped ? block.mapped + offset : nullptr;
        return allocation;
    };

    const bool dedicated = requirements.size > kBlockBytes / 4;
    if (!dedicated)
        for (auto& block : blocks_)
            if (block->type == types.front() && block->image == image && !block->dedicated)
                if (auto offset = carve(*block)) return make(*block, *offset);

    const VkDeviceSize bytes = dedicated ? requirements.size : kBlockBytes;
    const auto isTooMuch = [&] { return most_ > 0 && isOnDevice(types.front()) && bytes_ + bytes > most_; };
    if (isTooMuch()) destroyEmptyBlocks();
    if (isTooMuch())
        throw LimitReached("it takes more than " + std::to_string(most_ >> 20) + " MiB of the device's memory");
    // A full heap is not the end where another memory type will do.
    for (std::size_t i = 0;; ++i) {
        try {
            Block& block = addBlock(types[i], bytes, image, dedicated);
            return make(block, *carve(block));
        } catch (const Failure&) {
            if (i + 1 == types.size()) throw;
            destroyEmptyBlocks();
        }
    }
}

void Memory::destroyEmptyBlocks()
{
    std::erase_if(blocks_, [&](const auto& block) {
        const bool empty = isEmpty(*block);
        if (empty) destroyBlock(*block);
        return empty;
    });
}

void Memory::release(Allocation& allocation)
{
    const std::lock_guard lock(mutex_);
    Block& block = *static_cast<Block*>(allocation.block_);
    const auto at = std::lower_bound(block.free.begin(), block.free.end(), allocation.offset_,
                                     [](const Range& range, VkDeviceSize offset) { return range.offset < offset; });
    auto it = block.free.insert(at, {allocation.offset_, allocation.size_});
    if (it + 1 != block.free.end() && it->offset + it->size == (it + 1)->offset) {
        it->size += (it + 1)->size;
        block.free.erase(it + 1);
    }
    if (it != block.free.begin() && (it - 1)->offset + (it - 1)->size == it->offset) {
        (it - 1)->size += it->size;
        it = block.free.erase(it) - 1;
    }
    const auto isSpare = [&](const auto& other) {
        return other.get() != &block && other->type == block.type && other->image == block.image && !other->dedicated &&
               isEmpty(*other);
    };
    if (isEmpty(block) && (block.dedicated || std::any_of(blocks_.begin(), blocks_.end(), isSpare))) {
        destroyBlock(block);
        std::erase_if(blocks_, [&](const auto& candidate) { return candidate.get() == &block; });
    }
    allocation.owner_ = nullptr;
}

} // namespace halflight::gpu
