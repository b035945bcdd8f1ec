#pragma once
// Results that processes may share, for code that knows no folder.

#include "halflight/bake/part_folder.h"
#include "halflight/base/bytes.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace halflight {

/// Gives a stage its results: from a folder of parts, where this or another process has kept them, else computed here.
/// Without a folder, everything is computed here. Values are trivially copyable, lists of such values, or have
/// archive() as ByteWriter describes it.
class Store {
public:
    Store() = default;
    /// The folder, which may be null, outlives the store.
    explicit Store(PartFolder* folder) : folder_(folder) {}

    /// Whether other processes compute parts of the same results now.
    [[nodiscard]] bool isShared() const { return folder_ != nullptr && folder_->isShared(); }
    [[nodiscard]] bool contains(std::string_view name) const { return folder_ != nullptr && folder_->contains(name); }

    /// The result of that name. compute() fills `value`, and returns false when cancelled; so does this.
    template<typename Value, typename Compute>
    bool computed(std::string_view name, Value& value, const Compute& compute) const
    {
        if (const auto bytes = folder_ != nullptr ? folder_->read(name) : std::nullopt) {
            ByteReader reader(*bytes);
            exchange(reader, value);
            if (reader.complete()) return true;
        }
        if (!compute()) return false;
        if (folder_ == nullptr) return true;
        ByteWriter writer;
        exchange(writer, value);
        folder_->write(name, writer.take()); // a full disk is the folder's status
        return true;
    }

    /// A list of results, of which processes share parts of `perPart` each. compute(first, end) fills
    /// out[first … end - 1] on all threads. False when cancelled, and where a shared folder cannot be written.
    template<typename Value, typename Compute>
    bool computedParts(std::string_view name, std::span<Value> out, std::size_t perPart, const Compute& compute) const
    {
        if (!isShared()) return compute(std::size_t(0), out.size());
        const auto partOf = [&](std::size_t part) {
            return out.subspan(part * perPart, std::min(perPart, out.size() - part * perPart));
        };
        const auto bytesOf = [&](std::size_t part) -> std::optional<std::vector<std::byte>> {
            const std::size_t first = part * perPart;
            if (!compute(first, first + partOf(part).size())) return std::nullopt;
            ByteWriter writer;
            for (Value& value : partOf(part)) exchange(writer, value);
            return writer.take();
        };
        const auto parts = folder_->complete(name, (out.size() + perPart - 1) / perPart, bytesOf);
        for (std::size_t part = 0; parts && part < parts->size(); ++part) {
            ByteReader reader((*parts)[part]);
            for (Value& value : partOf(part)) exchange(reader, value);
            if (!reader.complete()) return false;
        }
        return parts.has_value();
    }

private:
    /// Writes a value, or reads it.
    template<typename Archive, typename Value> static void exchange(Archive& archive, Value& value)
    {
        if constexpr (requires { value.archive(archive); }) {
            value.archive(archive);
        } else {
            archive(value);
        }
    }

    PartFolder* folder_ = nullptr;
};

} // namespace halflight
