#pragma once
// The device of these tests: Mesa's driver for the CPU with the validation layer, or the one that
// HALFLIGHT_TEST_DEVICE names.

#include "gpu/device.h"

#include "halflight/bake_gpu/gpu_integrator.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

namespace halflight::test {

/// Part of the device's name.
inline std::string testDeviceName()
{
    const char* name = std::getenv("HALFLIGHT_TEST_DEVICE");
    return name != nullptr ? name : "lavapipe";
}

/// Tests of a suite share one device. They are skipped where there is none that traces rays.
class BakeDeviceTest : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        const std::string name = testDeviceName();
        auto opened = openBakeDevice({.name = name, .validation = name == "lavapipe"});
        if (opened)
            device = *opened;
        else
            why = opened.error().message;
    }
    static void TearDownTestSuite()
    {
        if (device != nullptr) EXPECT_EQ(validationMessages(*device), std::vector<std::string>{});
        device.reset();
    }
    void SetUp() override
    {
        if (device == nullptr) GTEST_SKIP() << why;
    }
    static inline std::shared_ptr<BakeDevice> device;
    static inline std::string why;
};

/// Until no other thread makes pipelines, which ask BakeDeviceOptions::fails too.
inline void waitForPipelines(BakeDevice& device)
{
    while (makesPipelines(device)) std::this_thread::yield();
}

/// A function of the driver that fails at one of its calls.
template<typename Function> class Fault;
template<typename... Arguments> class Fault<VkResult(VKAPI_PTR*)(Arguments...)> {
public:
    using Function = VkResult(VKAPI_PTR*)(Arguments...);
    Fault(Function& place, int call, VkResult result) : place_(place)
    {
        own = place;
        left = call;
        outcome = result;
        place = &run;
    }
    ~Fault() { place_ = own; }
    Fault(const Fault&) = delete;
    Fault& operator=(const Fault&) = delete;
    [[nodiscard]] static bool happened() { return left < 0; }

private:
    static VkResult VKAPI_PTR run(Arguments... arguments) { return left-- == 0 ? outcome : own(arguments...); }
    Function& place_;
    static inline Function own = nullptr;
    static inline int left = 0;
    static inline VkResult outcome = VK_SUCCESS;
};

} // namespace halflight::test
