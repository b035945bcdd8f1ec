#pragma once

#include "halflight/base/progress.h"

#include <cstddef>
#include <mutex>
#include <vector>

namespace halflight {

/// The progress of several parts of equal size that run at one time. The whole outlives it.
class ProgressOfParts {
public:
    ProgressOfParts(const Progress& whole, std::size_t parts) : whole_(whole), done_(parts, 0.0) {}
    /// Of one part, which reports from one thread at a time. The object outlives it.
    Progress part(std::size_t index)
    {
        Progress part;
        part.cancel = whole_.cancel;
        if (!whole_.report) return part;
        part.report = [this, index](std::string_view stage, double fraction) {
            const std::lock_guard lock(mutex_);
            if (fraction <= done_[index]) return; // parts of several passes begin again at 0
            sum_ += fraction - done_[index];
            done_[index] = fraction;
            whole_.report(stage, sum_ / double(done_.size()));
        };
        return part;
    }

private:
    const Progress& whole_;
    std::mutex mutex_;
    std::vector<double> done_; ///< fraction of each part
    double sum_ = 0.0;
};

} // namespace halflight
