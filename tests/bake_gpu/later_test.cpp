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
    Later<int> later(make);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            if (t % 2 == 0) later.begin();
            EXPECT_EQ(later.get(), 1);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(made, 1);
}

TEST(LaterS6, IsMadeBesideTheCaller)
{
    std::latch caller(1);
    Later<int> later([&] {
        caller.wait();
        return 7;
    });
    EXPECT_FALSE(later.isMaking());
    later.begin();
    EXPECT_TRUE(later.isMaking());
    caller.count_down();
    EXPECT_EQ(later.get(), 7);
    EXPECT_FALSE(later.isMaking());
}

TEST(LaterS6, ThrowsWhatMakingHasThrownAndIsMadeAnew)
{
    bool fails = true;
    Later<int> later([&] { return fails ? throw std::runtime_error("no memory") : 7; });
    later.begin();
    EXPECT_THROW(later.get(), std::runtime_error);
    EXPECT_THROW(later.get(), std::runtime_error);
    fails = false;
    EXPECT_EQ(later.get(), 7);
    fails = true;
    EXPECT_EQ(later.get(), 7);
}

} // namespace
} // namespace halflight::test
