#pragma once

#include <concepts>
#include <memory>
#include <type_traits>
#include <utility>

namespace halflight {

/// A function that is called while the caller waits: a pointer to the function object and one to its call. Unlike
/// std::function it copies nothing, so it must not outlive the call that it is passed to.
template<typename Signature> class FunctionRef;

template<typename Result, typename... Arguments> class FunctionRef<Result(Arguments...)> {
public:
    template<typename Function>
    requires(!std::same_as<Function, FunctionRef> && std::is_invocable_r_v<Result, const Function&, Arguments...>)
        FunctionRef(const Function& function)
        : object_(std::addressof(function)), call_([](const void* object, Arguments... arguments) -> Result {
              return (*static_cast<const Function*>(object))(std::forward<Arguments>(arguments)...);
          })
    {}

    Result operator()(Arguments... arguments) const { return call_(object_, std::forward<Arguments>(arguments)...); }

private:
    const void* object_;
    Result (*call_)(const void*, Arguments...);
};

} // namespace halflight
