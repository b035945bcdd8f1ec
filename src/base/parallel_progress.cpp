#include "halflight/base/parallel.h"

#include <mutex>

namespace halflight {

bool parallelFor(std::size_t count, std::size_t grain, const Progress& progress, std::string_view stage,
                 FunctionRef<void(std::size_t, std::size_t)> body)
{
    progress(stage, 0.0);
    std::mutex mutex;
    std::size_t done = 0;
    parallelFor(count, grain, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) return;
        body(begin, end);
        const std::lock_guard lock(mutex);
        done += end - begin;
        progress(stage, double(done) / double(count));
    });
    if (progress.cancelled()) return false;
    progress(stage, 1.0);
    return true;
}

} // namespace halflight
