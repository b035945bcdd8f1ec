#pragma once
// Values as bytes and back, for files that one machine writes and machines of the same byte order read.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace halflight {

/// Appends values to a list of bytes. Types that are kept have a template `archive(archive)`, which calls
/// archive(members…): a ByteWriter writes them, a ByteReader reads them.
class ByteWriter {
public:
    template<typename... T> void operator()(const T&... values) { (add(values), ...); }
    template<typename T> ByteWriter& add(const T& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        return raw(&value, sizeof(value));
    }
    template<typename T> ByteWriter& add(const std::vector<T>& values)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        add(uint64_t(values.size()));
        return raw(values.data(), values.size() * sizeof(T));
    }
    ByteWriter& add(const std::string& text)
    {
        add(uint64_t(text.size()));
        return raw(text.data(), text.size());
    }
    ByteWriter& raw(const void* data, std::size_t count)
    {
        const auto* first = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), first, first + count);
        return *this;
    }
    [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

/// Reads what a ByteWriter wrote, in the same order. After a read beyond the end, ok() is false and values are zero.
class ByteReader {
public:
    explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

    template<typename... T> void operator()(T&... values) { (read(values), ...); }
    template<typename T> ByteReader& read(T& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        const std::span<const std::byte> bytes = raw(sizeof(T));
        if (!ok_) {
            value = T{};
        } else {
            std::memcpy(static_cast<void*>(&value), bytes.data(), sizeof(T));
        }
        return *this;
    }
    template<typename T> ByteReader& read(std::vector<T>& values)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        uint64_t count = 0;
        read(count);
        values.clear();
        if (!ok_ || count > rest_.size() / sizeof(T)) return fail();
        values.resize(std::size_t(count));
        const std::span<const std::byte> bytes = raw(values.size() * sizeof(T));
        if (!values.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
        return *this;
    }
    ByteReader& read(std::string& text)
    {
        std::vector<char> letters;
        read(letters);
        text.assign(letters.begin(), letters.end());
        return *this;
    }
    /// The next bytes; empty beyond the end.
    std::span<const std::byte> raw(std::size_t count)
    {
        if (!ok_ || count > rest_.size()) {
            fail();
            return {};
        }
        const std::span<const std::byte> bytes = rest_.first(count);
        rest_ = rest_.subspan(count);
        return bytes;
    }
    [[nodiscard]] bool ok() const { return ok_; }
    [[nodiscard]] bool atEnd() const { return rest_.empty(); }
    /// Whether all bytes were read, and no more.
    [[nodiscard]] bool complete() const { return ok_ && rest_.empty(); }

private:
    ByteReader& fail()
    {
        ok_ = false;
        rest_ = {};
        return *this;
    }
    std::span<const std::byte> rest_;
    bool ok_ = true;
};

} // namespace halflight
