#pragma once

#include "halflight/base/progress.h"

#include <cstddef>
#include <functional>
#include <string_view>

namespace halflight {

/// Sets how many threads parallelFor uses from now on (0 = all cores) until the object goes out of scope. No result of
/// this project depends on the number.
class ThreadLimit {
public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    void* control_;
};

/// Number of threads parallelFor uses now.
int threadCount();

/// Calls body(begin, end) on disjoint ranges that cover [0, count), `grain` items each at most, on all threads.
void parallelFor(std::size_t count, std::size_t grain,
                 const std::function<void(std::size_t begin, std::size_t end)>& body);

/// The same, reporting progress under `stage` as ranges finish. Returns false when it was cancelled: ranges not yet
/// begun are then skipped.
bool parallelFor(std::size_t count, std::size_t grain, const Progress& progress, std::string_view stage,
                 const std::function<void(std::size_t begin, std::size_t end)>& body);

} // namespace halflight
