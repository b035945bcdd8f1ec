#include "scene/model/wide.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace halflight::wide_test {
namespace {

// What other compilers use in the place of this compiler's own integers of 128 bits.
TEST(TwoWords, AreTheCompilersIntegers)
{
#ifndef __SIZEOF_INT128__
    GTEST_SKIP() << "this compiler has no integers of 128 bits";
#else
    using Limits = std::numeric_limits<int64_t>;
    std::vector<int64_t> numbers = {
        0, 1, -1, 2, -2, 0xffffffff, 0x100000000, -0x100000000, Limits::max(), Limits::min(), Limits::min() + 1};
    std::mt19937_64 random(1);
    for (int i = 0; i < 60; ++i) numbers.push_back(int64_t(random()) >> (i % 63));
    const auto expectEqual = [](TwoWords words, Wide wide) {
        EXPECT_EQ(words.low(), uint64_t(wide));
        EXPECT_EQ(words.high(), uint64_t(wide >> 64));
    };
    for (const int64_t a : numbers) {
        for (const int64_t b : numbers) {
            const TwoWords product = TwoWords(a) * b;
            const Wide wide = Wide(a) * b;
            expectEqual(product, wide);
            expectEqual(TwoWords(a) + b, Wide(a) + b);
            for (const int64_t c : {a, b, int64_t(3)}) {
                EXPECT_EQ(product < TwoWords(c), wide < c);
                EXPECT_EQ(product > TwoWords(c), wide > c);
                EXPECT_EQ(product == TwoWords(c), wide == c);
            }
            // As in the test of a sphere: products of products, which must not go beyond 128 bits.
            if (a > -(int64_t(1) << 40) && a < int64_t(1) << 40) {
                const TwoWords more = product * (a % 1'000'000) + product;
                expectEqual(more, wide * (a % 1'000'000) + wide);
                EXPECT_EQ(more < 0, wide * (a % 1'000'000) + wide < 0);
            }
        }
    }
#endif
}

} // namespace
} // namespace halflight::wide_test
