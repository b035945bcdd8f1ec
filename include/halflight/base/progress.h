#pragma once

#include <atomic>
#include <functional>
#include <string_view>

namespace halflight {

/// How a long function tells its caller where it stands, and how the caller stops it.
/// Both members may be empty. `report` may be called from any thread, but never from two at once.
struct Progress {
    /// `stage` names the work ("lightmap"), `fraction` is 0…1 within it.
    std::function<void(std::string_view stage, double fraction)> report;
    /// Set to true (from a signal handler, say) to make the function return ErrorCode::Cancelled soon.
    const std::atomic<bool>* cancel = nullptr;

    [[nodiscard]] bool cancelled() const { return cancel != nullptr && cancel->load(std::memory_order_relaxed); }
    void operator()(std::string_view stage, double fraction) const
    {
        if (report) report(stage, fraction);
    }
};

/// A part of a progress: fractions begin…end of the whole, which outlives it.
inline Progress partOf(const Progress& whole, double begin, double end)
{
    Progress part;
    part.cancel = whole.cancel;
    if (whole.report) {
        part.report = [&whole, begin, end](std::string_view stage, double fraction) {
            whole.report(stage, begin + (end - begin) * fraction);
        };
    }
    return part;
}

} // namespace halflight
