// Searches whose trials run ahead give what one trial after another gives.

#include "unwrap/pack/trials.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace halflight::charts {
namespace {

/// Halves a bracket of whole numbers; a trial succeeds below a limit.
struct Bisection {
    int low = 0;
    int high = 1000;
    int value = 500;
    bool done = false;

    [[nodiscard]] Bisection after(bool succeeded) const
    {
        Bisection next = *this;
        (succeeded ? next.low : next.high) = value;
        next.value = (next.low + next.high) / 2;
        next.done = next.high - next.low <= 1;
        return next;
    }
};

TEST(Trials, RunningAheadChangesNoResult)
{
    for (const int limit : {1, 2, 77, 499, 500, 501, 998, 1000}) {
        for (const int depth : {1, 2, 3, 4, 5}) {
            Bisection search;
            std::atomic<int> count = 0;
            int rounds = 0;
            const auto evaluate = [&](int value) {
                ++count;
                return value < limit ? std::optional(value) : std::nullopt;
            };
            const auto report = [&](const Bisection&) { ++rounds; };
            const std::optional<int> best = searchByTrials<int>(search, depth, evaluate, report);
            EXPECT_EQ(best, limit > 1 ? std::optional(limit - 1) : std::nullopt) << depth;
            EXPECT_EQ(search.low, limit - 1);
            // Ten trials one after another are ten rounds, with depth 5 two, of at most 31 trials.
            EXPECT_LE(rounds, (10 + depth - 1) / depth);
            EXPECT_LE(count, rounds * ((1 << depth) - 1));
            if (depth == 1) EXPECT_EQ(count, rounds) << "nothing is done in vain on one or two threads";
        }
    }
}

TEST(Trials, DepthFollowsTheThreads)
{
    const std::vector<std::pair<int, int>> depthOfThreads = {{1, 1}, {2, 1}, {3, 2},  {6, 2},
                                                             {7, 3}, {8, 3}, {15, 4}, {16, 4}};
    for (const auto& [threads, depth] : depthOfThreads) EXPECT_EQ(trialDepth(threads), depth) << threads;
}

} // namespace
} // namespace halflight::charts
