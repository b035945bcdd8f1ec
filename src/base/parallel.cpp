#include "halflight/base/parallel.h"

#include <algorithm>
#include <mutex>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace halflight {

ThreadLimit::ThreadLimit(int threads)
    : control_(threads > 0 ? new tbb::global_control(tbb::global_control::max_allowed_parallelism, std::size_t(threads))
                           : nullptr)
{}

ThreadLimit::~ThreadLimit()
{
    delete static_cast<tbb::global_control*>(control_);
}

int threadCount()
{
    return std::min(int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)),
                    tbb::info::default_concurrency());
}

void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body)
{
    if (count == 0) return;
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, std::max<std::size_t>(grain, 1)),
        [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); },
        tbb::simple_partitioner());
}

bool parallelFor(std::size_t count, std::size_t grain, const Progress& progress, std::string_view stage,
                 const std::function<void(std::size_t, std::size_t)>& body)
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

void inIsolation(const std::function<void()>& body)
{
    tbb::this_task_arena::isolate([&] { body(); });
}

} // namespace halflight
