#pragma once
// std::atomic_ref, and its part that is used here where the library lacks it (libc++ before 19: Emscripten's, Apple's).

#include <atomic>

namespace halflight {

#ifdef __cpp_lib_atomic_ref

template<typename T> using AtomicRef = std::atomic_ref<T>;

#else

/// As std::atomic_ref; every order of memory is the strictest.
template<typename T> class AtomicRef {
public:
    explicit AtomicRef(T& object) : object_(&object) {}

    T load(std::memory_order = std::memory_order_seq_cst) const { return __atomic_load_n(object_, __ATOMIC_SEQ_CST); }
    void store(T value, std::memory_order = std::memory_order_seq_cst) const
    {
        __atomic_store_n(object_, value, __ATOMIC_SEQ_CST);
    }
    bool compare_exchange_strong(T& expected, T value, std::memory_order = std::memory_order_seq_cst) const
    {
        return __atomic_compare_exchange_n(object_, &expected, value, false, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST);
    }
    bool compare_exchange_weak(T& expected, T value, std::memory_order = std::memory_order_seq_cst) const
    {
        return __atomic_compare_exchange_n(object_, &expected, value, true, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST);
    }
    T fetch_add(T value, std::memory_order = std::memory_order_seq_cst) const
    {
        return __atomic_fetch_add(object_, value, __ATOMIC_SEQ_CST);
    }

private:
    T* object_;
};

#endif

} // namespace halflight
