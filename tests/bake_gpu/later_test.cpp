// A device's pipelines, which drivers compile for seconds, are made beside other work (spec S6: on a GPU).

#include "bake_gpu/later.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

namespace halflight::test {
namespace {

TEST(LaterS6, IsMadeOnceHoweverManyThreadsAsk)
{
    std::atomic<int> made = 0;
    const auto make = [&] { return ++made; };
    Later<int> later;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            if (t % 2 == 0) later.begin(make);
            EXPECT_EQ(later.get(make), 1);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(made, 1);
}

TEST(LaterS6, IsMadeBesideTheCaller)
{
    std::latch caller(1);
    Later<int> later;
    EXPECT_FALSE(later.isMaking());
    const auto make = [&] {
        caller.wait();
        return 7;
    };
    later.begin(make);
    EXPECT_TRUE(later.isMaking());
    caller.count_down();
    EXPECT_EQ(later.get(make), 7);
    EXPECT_FALSE(later.isMaking());
}

TEST(LaterS6, ThrowsWhatMakingHasThrownAndIsMadeAnew)
{
    const auto fail = []() -> int { throw std::runtime_error("no memory"); };
    Later<int> later;
    later.begin(fail);
    EXPECT_THROW(later.get(fail), std::runtime_error);
    EXPECT_THROW(later.get(fail), std::runtime_error);
    EXPECT_EQ(later.get([] { return 7; }), 7);
    EXPECT_EQ(later.get(fail), 7);
}

} // namespace
} // namespace halflight::test
