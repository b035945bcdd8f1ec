#include "halflight/base/parallel.h"

#include <algorithm>
#include <deque>
#include <mutex>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#include <utility>

#ifdef HALFLIGHT_SANITIZE_THREADS
extern "C" void __tsan_acquire(void*); // NOLINT: ThreadSanitizer's
extern "C" void __tsan_release(void*); // NOLINT
#endif

namespace halflight {

/// What ThreadSanitizer has to know of parallelFor() and Background: bodies begin after the object is made and end
/// before joined().
/// oneTBB's own synchronization is not instrumented. Empty in other builds.
class ForkAndJoin {
public:
#ifdef HALFLIGHT_SANITIZE_THREADS
    ForkAndJoin()
    {
        __tsan_release(&fork_);
    }
    void bodyBegins()
    {
        __tsan_acquire(&fork_);
    }
    void bodyEnds()
    {
        __tsan_release(&join_);
    }
    void joined()
    {
        __tsan_acquire(&join_);
    }

private:
    char fork_ = 0;
    char join_ = 0;
#else
    void bodyBegins() {}
    void bodyEnds() {}
    void joined() {}
#endif
};

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

void parallelFor(std::size_t count, std::size_t grain, FunctionRef<void(std::size_t, std::size_t)> body)
{
    if (count == 0) return;
    ForkAndJoin threads;
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, std::max<std::size_t>(grain, 1)),
        [&](const tbb::blocked_range<std::size_t>& range) {
            threads.bodyBegins();
            body(range.begin(), range.end());
            threads.bodyEnds();
        },
        tbb::simple_partitioner());
    threads.joined();
}

void inIsolation(FunctionRef<void()> body)
{
    tbb::this_task_arena::isolate([&] { body(); });
}

class Background::Queue {
public:
    void run(std::function<void()> body)
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(body));
        if (waiting_.size() > 1) return; // goes on with this one
        group_.run([this] {
            threads_.bodyBegins();
            inIsolation([this] { runAll(); });
            threads_.bodyEnds();
        });
    }
    void wait()
    {
        group_.wait();
        threads_.joined();
    }

private:
    /// The function that runs stays at the front. One that throws takes the others with it.
    void runAll()
    {
        std::unique_lock lock(mutex_);
        while (!waiting_.empty()) {
            const std::function<void()> body = std::move(waiting_.front());
            lock.unlock();
            try {
                body();
            } catch (...) {
                lock.lock();
                waiting_.clear();
                throw;
            }
            lock.lock();
            waiting_.pop_front();
        }
    }

    std::mutex mutex_;
    std::deque<std::function<void()>> waiting_;
    ForkAndJoin threads_;
    tbb::task_group group_;
};

Background::Background() : queue_(std::make_unique<Queue>()) {}

Background::~Background()
{
    try {
        queue_->wait();
    } catch (...) { // the caller has left, and has an error of its own
    }
}

void Background::run(std::function<void()> body)
{
    if (threadCount() > 1)
        queue_->run(std::move(body));
    else
        body();
}

void Background::wait()
{
    queue_->wait();
}

} // namespace halflight
