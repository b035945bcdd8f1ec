#include "halflight/base/parallel.h"

#include "halflight/base/memory.h"
#include "halflight/base/progress_of_parts.h"
#include "halflight/shading/random.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <gtest/gtest.h>
#include <mutex>
#include <new>
#include <set>
#include <thread>
#include <vector>

namespace halflight::parallel_test {
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

#ifdef __SANITIZE_THREAD__
/// The annotations of parallelFor() hide no race of its bodies, neither with each other nor with another thread.
TEST(ParallelForDeathTest, RacesOfBodiesAreFound)
{
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    constexpr int kExitCode = 66; // ThreadSanitizer's
    const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
    const auto amongBodies = [&] {
        int sum = 0;
        parallelFor(1000, 1, [&](std::size_t, std::size_t) {
            pause();
            ++sum;
        });
        std::exit(0);
    };
    const auto withAnotherThread = [&] {
        int sum = 0;
        std::thread other([&] { ++sum; });
        parallelFor(100, 1, [&](std::size_t begin, std::size_t) {
            pause();
            if (begin == 50) ++sum;
        });
        other.join();
        std::exit(0);
    };
    EXPECT_EXIT(amongBodies(), testing::ExitedWithCode(kExitCode), "data race");
    EXPECT_EXIT(withAnotherThread(), testing::ExitedWithCode(kExitCode), "data race");
}
#endif

/// Functions end in their order, beside a caller that goes on in isolation, and when there is one thread.
TEST(Background, FunctionsRunOneAfterAnother)
{
    for (const int threads : {1, 2, 5}) {
        const ThreadLimit limit(threads);
        constexpr int kFunctions = 20;
        std::vector<int> order;
        std::atomic<int> running = 0;
        std::atomic<int> foreground = 0;
        Background background;
        inIsolation([&] {
            for (int i = 0; i < kFunctions; ++i) {
                background.run([&, i] {
                    EXPECT_EQ(++running, 1);
                    std::atomic<int> items = 0;
                    parallelFor(64, 1, [&](std::size_t begin, std::size_t end) { items += int(end - begin); });
                    EXPECT_EQ(items, 64);
                    order.push_back(i);
                    --running;
                });
                parallelFor(64, 1, [&](std::size_t begin, std::size_t end) { foreground += int(end - begin); });
            }
        });
        background.wait();
        EXPECT_EQ(foreground, 64 * kFunctions);
        ASSERT_EQ(int(order.size()), kFunctions);
        EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
    }
}

/// What a function throws comes out of wait(), or is dropped where the caller leaves.
TEST(Background, ExceptionsReachTheCallerThatWaits)
{
    const ThreadLimit limit(4);
    Background background;
    background.run([] { throw std::bad_alloc(); });
    EXPECT_THROW(background.wait(), std::bad_alloc);
    bool goesOn = false;
    background.run([&] { goesOn = true; });
    background.wait();
    EXPECT_TRUE(goesOn);
    Background left;
    left.run([] { throw std::bad_alloc(); });
}

TEST(ParallelSort, IsThatOfOneThread)
{
    // Around the ends of blocks and of pairs of runs; many equal items.
    for (const std::size_t count : {0u, 1u, 65535u, 65536u, 65537u, 131073u, 400000u}) {
        std::vector<uint32_t> values(count);
        for (std::size_t i = 0; i < count; ++i) values[i] = hashPcg(uint32_t(i)) % 50000u;
        std::vector<uint32_t> expected = values;
        std::sort(expected.begin(), expected.end());
        parallelSort(values, std::less<>());
        EXPECT_EQ(values, expected) << count;
    }
}

TEST(IndicesWhere, AreAscendingAndComplete)
{
    for (const std::size_t count : {0u, 5u, 65536u, 200001u}) {
        const auto wanted = [](std::size_t i) { return hashPcg(uint32_t(i)) % 3 == 0; };
        std::vector<uint32_t> expected;
        for (uint32_t i = 0; i < count; ++i) {
            if (wanted(i)) expected.push_back(i);
        }
        EXPECT_EQ(indicesWhere(count, wanted), expected) << count;
    }
}

TEST(ProgressOfParts, GrowsToOneThoughPartsBeginAgain)
{
    double last = 0.0;
    bool grew = true;
    Progress whole;
    whole.report = [&](std::string_view, double fraction) {
        grew = grew && fraction > last;
        last = fraction;
    };
    ProgressOfParts parts(whole, 8);
    parallelFor(8, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const Progress part = parts.part(p);
            for (int pass = 0; pass < 3; ++pass) {
                parallelFor(100, 10, part, "stage", [](std::size_t, std::size_t) {});
            }
        }
    });
    EXPECT_TRUE(grew);
    EXPECT_NEAR(last, 1.0, 1.0e-9);
}

TEST(LargeVector, HasItsValues)
{
    for (const std::size_t count : {0u, 3u, 10'000'000u}) {
        const std::vector<uint32_t> values = largeVector<uint32_t>(count, 7u);
        EXPECT_EQ(values.size(), count);
        EXPECT_TRUE(std::all_of(values.begin(), values.end(), [](uint32_t v) { return v == 7u; }));
    }
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
} // namespace halflight::parallel_test
