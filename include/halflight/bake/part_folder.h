#pragma once
// A folder of finished results ("parts") that several processes and machines may fill at the same time.
//
// A part is a function of the inputs that the folder is named after, so that all processes write the same values under
// one name. It is written under a temporary name, then renamed, and carries a checksum. So computing a part twice is
// harmless, nothing is locked, and no process waits for another.

#include "halflight/base/result.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace halflight {

/// The share of the work that a process does first: number `index` of `count`.
struct WorkShare {
    uint32_t index = 0;
    uint32_t count = 1;
};

class PartFolder {
public:
    /// The folder is made when the first part is written.
    explicit PartFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Other processes fill the folder at the same time: parts of stages are kept too, not only their results.
    void shareWith(WorkShare share) { share_ = share; }
    [[nodiscard]] bool isShared() const { return share_.has_value(); }
    [[nodiscard]] WorkShare share() const { return share_.value_or(WorkShare{}); }

    [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
    [[nodiscard]] std::filesystem::path fileOf(std::string_view name) const;
    /// Whether the part is there; its checksum is not looked at.
    [[nodiscard]] bool contains(std::string_view name) const;
    /// The bytes of a part; nothing if it is missing or its checksum is wrong.
    [[nodiscard]] std::optional<std::vector<std::byte>> read(std::string_view name) const;
    /// Keeps the first error for status().
    bool write(std::string_view name, std::span<const std::byte> bytes);
    [[nodiscard]] const Status& status() const { return status_; }
    /// Removes what killed processes left under temporary names, once that is older than `age`.
    void removeAbandoned(std::chrono::hours age) const;

    /// The parts 0 … count - 1 of a stage, in order. In a shared folder a process computes the missing parts of its
    /// share, then those that no process has written yet. Errors: those of `compute`, and WriteFailed when a shared
    /// folder cannot be written.
    using Compute = std::function<Result<std::vector<std::byte>>(std::size_t part)>;
    Result<std::vector<std::vector<std::byte>>> complete(std::string_view stage, std::size_t count,
                                                         const Compute& compute);

private:
    std::filesystem::path folder_;
    std::optional<WorkShare> share_;
    Status status_;
};

/// "lightmap-00017".
std::string partName(std::string_view stage, std::size_t part);

/// 0 … count - 1 in the order in which a process takes them: its share, then the others at random. Processes that have
/// finished their shares seldom take the same one.
std::vector<std::size_t> workOrder(std::size_t count, WorkShare share);

} // namespace halflight
