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
    template<typename Make> void begin(const Make& make) { makingBy(std::launch::async, make); }
    /// The value. It is made now unless it has begun. Throws what make() has thrown.
    template<typename Make> const T& get(const Make& make) { return makingBy(std::launch::deferred, make).get(); }

    /// Whether another thread makes it.
    [[nodiscard]] bool isMaking()
    {
        const std::lock_guard lock(mutex_);
        return value_.valid() && value_.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
    }

private:
    template<typename Make> std::shared_future<T> makingBy(std::launch policy, const Make& make)
    {
        const std::lock_guard lock(mutex_);
        if (!value_.valid()) value_ = std::async(policy, make).share();
        return value_;
    }

    std::mutex mutex_; ///< guards the future, not what it makes
    std::shared_future<T> value_;
};

} // namespace halflight
