#pragma once
// Content hashes: equal inputs, equal hashes, on every run and machine of the same byte order. Not for secrets.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace halflight {

struct Hash128 {
    uint64_t low = 0;
    uint64_t high = 0;
    auto operator<=>(const Hash128&) const = default;
    /// 32 hexadecimal digits.
    [[nodiscard]] std::string hex() const;
};

/// Takes in bytes piece by piece (XXH3, 128 bits). Only types without padding may be added.
class Hasher {
public:
    Hasher();
    ~Hasher();
    Hasher(const Hasher&) = delete;
    Hasher& operator=(const Hasher&) = delete;

    Hasher& bytes(const void* data, std::size_t count);
    template<typename T> Hasher& add(const T& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        return bytes(&value, sizeof(value));
    }
    /// Length first, so that neighbouring lists do not run into each other.
    template<typename T> Hasher& add(const std::vector<T>& values)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        add(uint64_t(values.size()));
        return bytes(values.data(), values.size() * sizeof(T));
    }
    Hasher& add(std::string_view text)
    {
        add(uint64_t(text.size()));
        return bytes(text.data(), text.size());
    }

    [[nodiscard]] Hash128 hash() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace halflight
