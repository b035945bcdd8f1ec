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

    /// The result of that name. compute() fills `value`. Its error is this one's, and keeps nothing.
    template<typename Value, typename Compute>
    Status computed(std::string_view name, Value& value, const Compute& compute) const
    {
        if (const auto bytes = folder_ != nullptr ? folder_->read(name) : std::nullopt) {
            ByteReader reader(*bytes);
            exchange(reader, value);
            if (reader.complete()) return {};
        }
        if (Status s = compute(); !s) return s;
        if (folder_ == nullptr) return {};
        ByteWriter writer;
        exchange(writer, value);
        folder_->write(name, writer.take()); // a full disk is the folder's status
        return {};
    }

    /// A list of results, of which processes share parts of `perPart` each. compute(first, end) fills
    /// out[first … end - 1] on all threads. Errors: its own, and those of PartFolder::complete().
    template<typename Value, typename Compute>
    Status computedParts(std::string_view name, std::span<Value> out, std::size_t perPart, const Compute& compute) const
    {
        if (!isShared()) return compute(std::size_t(0), out.size());
        const auto partOf = [&](std::size_t part) {
            return out.subspan(part * perPart, std::min(perPart, out.size() - part * perPart));
        };
        const auto bytesOf = [&](std::size_t part) -> Result<std::vector<std::byte>> {
            const std::size_t first = part * perPart;
            if (Status s = compute(first, first + partOf(part).size()); !s) return s.error();
            ByteWriter writer;
            for (Value& value : partOf(part)) exchange(writer, value);
            return writer.take();
        };
        const auto parts = folder_->complete(name, (out.size() + perPart - 1) / perPart, bytesOf);
        if (!parts) return parts.error();
        for (std::size_t part = 0; part < parts->size(); ++part) {
            ByteReader reader((*parts)[part]);
            for (Value& value : partOf(part)) exchange(reader, value);
            if (!reader.complete())
                return Error{ErrorCode::FileInvalid, "a part of the cache is not what its name says"};
        }
        return {};
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
