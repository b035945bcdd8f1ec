#include "halflight/base/parallel.h"
#include "halflight/base/random.h"

#include <algorithm>
#include <atomic>
#include <gtest/gtest.h>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace halflight {
namespace {

TEST(ParallelFor, CoversEveryItemOnce)
{
    for (const std::size_t count : {std::size_t(0), std::size_t(1), std::size_t(7), std::size_t(100003)}) {
        for (const std::size_t grain : {std::size_t(0), std::size_t(1), std::size_t(64), std::size_t(1) << 40}) {
            if (count > 1000 && grain < 2) continue; // a hundred thousand calls show nothing more
            std::vector<std::atomic<int>> visits(count);
            parallelFor(count, grain, [&](std::size_t begin, std::size_t end) {
                EXPECT_LT(begin, end);
                EXPECT_LE(end - begin, std::max<std::size_t>(grain, 1));
                for (std::size_t i = begin; i < end; ++i) visits.at(i)++;
            });
            for (const auto& visit : visits) ASSERT_EQ(visit.load(), 1);
        }
    }
}

TEST(ParallelFor, ThreadLimitHoldsAndEnds)
{
    const int before = threadCount();
    {
        const ThreadLimit one(1);
        EXPECT_EQ(threadCount(), 1);
        std::mutex mutex;
        std::set<std::thread::id> threads;
        parallelFor(1000, 1, [&](std::size_t, std::size_t) {
            const std::lock_guard lock(mutex);
            threads.insert(std::this_thread::get_id());
        });
        EXPECT_EQ(threads.size(), 1u);
    }
    EXPECT_EQ(threadCount(), before);
    const ThreadLimit all(0);
    EXPECT_EQ(threadCount(), before);
}

TEST(ParallelFor, ProgressGrowsToOneFromOneThreadAtATime)
{
    std::atomic<int> inside{0};
    double last = -1.0;
    bool grew = true;
    bool alone = true;
    std::string stageSeen;
    Progress progress;
    progress.report = [&](std::string_view stage, double fraction) {
        alone = alone && inside.fetch_add(1) == 0;
        grew = grew && fraction >= last;
        last = fraction;
        stageSeen = stage;
        inside.fetch_sub(1);
    };
    EXPECT_TRUE(parallelFor(5000, 10, progress, "stage", [](std::size_t, std::size_t) {}));
    EXPECT_TRUE(grew);
    EXPECT_TRUE(alone);
    EXPECT_EQ(last, 1.0);
    EXPECT_EQ(stageSeen, "stage");
}

TEST(ParallelFor, CancelStopsSoon)
{
    std::atomic<bool> cancel{false};
    std::atomic<int> done{0};
    Progress progress;
    progress.cancel = &cancel;
    EXPECT_FALSE(parallelFor(100000, 1, progress, "stage", [&](std::size_t, std::size_t) {
        if (++done == 10) cancel = true;
    }));
    EXPECT_LT(done.load(), 10 + 2 * std::max(threadCount(), 1) + 1) << "only ranges already begun finish";
}

TEST(Random, HashIsOneToOneAndUniform)
{
    // PCG's permutation: no two inputs meet. A million inputs, by sorting.
    std::vector<uint32_t> values(1u << 20);
    double sum = 0.0;
    for (uint32_t i = 0; i < values.size(); ++i) {
        values[i] = hashPcg(i);
        sum += double(unitFloat(values[i]));
        ASSERT_LT(unitFloat(values[i]), 1.0f);
    }
    EXPECT_NEAR(sum / double(values.size()), 0.5, 2e-3);
    std::sort(values.begin(), values.end());
    EXPECT_EQ(std::adjacent_find(values.begin(), values.end()), values.end());
    EXPECT_LT(unitFloat(0xffffffffu), 1.0f);
    EXPECT_EQ(unitFloat(0u), 0.0f);
    EXPECT_NE(hashCombine(1, 2), hashCombine(2, 1));
}

} // namespace
} // namespace halflight
