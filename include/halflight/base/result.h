#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace halflight {

/// Kinds of failure that a caller may want to tell apart. Everything a user's file or machine can cause is one of
/// these; a broken contract of the API is an assert instead.
enum class ErrorCode {
    FileNotFound,    ///< the file does not exist or cannot be opened
    FileInvalid,     ///< the file is not what its name says, or breaks its format's rules
    Unsupported,     ///< valid, but needs something this program does not do (a required extension, say)
    WriteFailed,     ///< the output could not be written
    InvalidArgument, ///< an option's value is out of its range, or options contradict one another
    DeviceFailed,    ///< no usable Vulkan device, or the device was lost or ran out of memory
    Cancelled,       ///< the caller asked to stop
};

/// One clear sentence about what went wrong, and where.
struct Error {
    ErrorCode code = ErrorCode::FileInvalid;
    std::string message; ///< a sentence without the file's name, e.g. "accessor reads past the end of its buffer view"
    std::string object =
        {}; ///< the offending object as a glTF path, e.g. "/meshes/0/primitives/1"; empty when it is the whole file

    [[nodiscard]] std::string text() const { return object.empty() ? message : object + ": " + message; }
};

/// A value or an error. Test with `if (!result)`; `*result` and `result->` are the value.
template<typename T> class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::move(value)) {}
    Result(Error error) : state_(std::move(error)) {}

    explicit operator bool() const { return state_.index() == 0; }
    T& operator*() &
    {
        assert(*this);
        return *std::get_if<0>(&state_);
    }
    const T& operator*() const&
    {
        assert(*this);
        return *std::get_if<0>(&state_);
    }
    T&& operator*() &&
    {
        assert(*this);
        return std::move(*std::get_if<0>(&state_));
    }
    T* operator->() { return &**this; }
    const T* operator->() const { return &**this; }
    [[nodiscard]] const Error& error() const
    {
        assert(!*this);
        return *std::get_if<1>(&state_);
    }

private:
    std::variant<T, Error> state_;
};

/// Success, or an error: the result of a function with nothing to return. Success costs no more than a flag.
class [[nodiscard]] Status {
public:
    Status() = default;
    Status(Error error) : error_(std::move(error)) {}
    explicit operator bool() const { return !error_.has_value(); }
    [[nodiscard]] const Error& error() const
    {
        assert(error_);
        return *error_;
    }

private:
    std::optional<Error> error_;
};

/// What a function returns that was cancelled.
inline Error cancelledError()
{
    return {ErrorCode::Cancelled, "interrupted"};
}

} // namespace halflight
