#include "halflight/base/memory.h"

#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace halflight::memory_test {
namespace {

TEST(Memory, ReleasedContainersHaveNoMemory)
{
    std::vector<int> numbers(1000);
    release(numbers);
    EXPECT_EQ(numbers.capacity(), 0u);

    std::string text(1000, 'x');
    release(text);
    EXPECT_EQ(text.capacity(), std::string().capacity());
}

} // namespace
} // namespace halflight::memory_test
