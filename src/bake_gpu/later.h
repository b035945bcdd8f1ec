#pragma once
// A value that takes seconds to make, such as a pipeline that the driver has not compiled before.

#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <utility>

namespace halflight {

/// Any thread may call the functions.
template<typename T> class Later {
public:
    explicit Later(std::function<T()> make) : make_(std::move(make)) {}

    /// Makes the value on a thread of its own from now on, unless it has begun.
    void begin() { making(std::launch::async); }
    /// The value. It is made now unless it has begun. Throws what make() has thrown; the next call makes it anew.
    const T& get()
    {
        const auto [value, number] = making(std::launch::deferred);
        try {
            return value.get();
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (number_ == number) value_ = {};
            throw;
        }
    }
    /// Whether another thread makes it.
    [[nodiscard]] bool isMaking()
    {
        const std::lock_guard lock(mutex_);
        return value_.valid() && value_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
    }

private:
    struct Making {
        std::shared_future<T> value;
        int number = 0;
    };
    Making making(std::launch policy)
    {
        const std::lock_guard lock(mutex_);
        if (!value_.valid()) {
            value_ = std::async(policy, make_).share();
            ++number_;
        }
        return {value_, number_};
    }

    std::function<T()> make_;
    std::mutex mutex_; ///< guards what follows, not what is made
    std::shared_future<T> value_;
    int number_ = 0; ///< how often it has begun
};

} // namespace halflight
