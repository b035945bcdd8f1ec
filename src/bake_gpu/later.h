#pragma once
// A value that takes seconds to make, such as a pipeline that the driver has not compiled before.

#include <chrono>
#include <future>
#include <mutex>

namespace halflight {

/// Any thread may call the functions.
template<typename T> class Later {
public:
    /// Makes the value on a thread of its own from now on, unless it has begun.
    template<typename Make> void begin(const Make& make) { making(std::launch::async, make); }
    /// The value. It is made now unless it has begun. Throws what make() has thrown; the next call makes it anew.
    template<typename Make> const T& get(const Make& make)
    {
        const auto [value, number] = making(std::launch::deferred, make);
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
    template<typename Make> Making making(std::launch policy, const Make& make)
    {
        const std::lock_guard lock(mutex_);
        if (!value_.valid()) {
            value_ = std::async(policy, make).share();
            ++number_;
        }
        return {value_, number_};
    }

    std::mutex mutex_; ///< guards what follows, not what is made
    std::shared_future<T> value_;
    int number_ = 0; ///< how often it has begun
};

} // namespace halflight
