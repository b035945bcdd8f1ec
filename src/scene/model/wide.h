#pragma once
// Integers of 128 bits, which not all compilers have (MSVC). Only what the predicates of tetrahedra need.

#include <compare>
#include <cstdint>

namespace halflight {

/// In two's complement, as two words; results beyond 128 bits wrap.
class TwoWords {
public:
    constexpr TwoWords(int64_t value = 0) : low_(uint64_t(value)), high_(value < 0 ? ~uint64_t(0) : 0) {}

    friend constexpr TwoWords operator+(TwoWords a, TwoWords b)
    {
        const uint64_t low = a.low_ + b.low_;
        return {low, a.high_ + b.high_ + (low < a.low_ ? 1 : 0)};
    }
    friend constexpr TwoWords operator*(TwoWords a, TwoWords b)
    {
        TwoWords product = productOf(a.low_, b.low_);
        product.high_ += a.low_ * b.high_ + a.high_ * b.low_;
        return product;
    }
    constexpr TwoWords& operator+=(TwoWords other) { return *this = *this + other; }

    friend constexpr bool operator==(TwoWords a, TwoWords b) = default;
    friend constexpr std::strong_ordering operator<=>(TwoWords a, TwoWords b)
    {
        return a.high_ != b.high_ ? int64_t(a.high_) <=> int64_t(b.high_) : a.low_ <=> b.low_;
    }

    [[nodiscard]] constexpr uint64_t low() const { return low_; }
    [[nodiscard]] constexpr uint64_t high() const { return high_; }

private:
    constexpr TwoWords(uint64_t low, uint64_t high) : low_(low), high_(high) {}
    /// Without signs, from halves of the words.
    static constexpr TwoWords productOf(uint64_t a, uint64_t b)
    {
        constexpr uint64_t kHalf = 0xffffffffu;
        const uint64_t lowest = (a & kHalf) * (b & kHalf);
        const uint64_t left = (a >> 32) * (b & kHalf) + (lowest >> 32);
        const uint64_t right = (a & kHalf) * (b >> 32) + (left & kHalf);
        return {right << 32 | (lowest & kHalf), (a >> 32) * (b >> 32) + (left >> 32) + (right >> 32)};
    }

    uint64_t low_;
    uint64_t high_;
};

#ifdef __SIZEOF_INT128__
__extension__ typedef __int128 Wide;
#else
using Wide = TwoWords;
#endif

} // namespace halflight
