#pragma once
// The device of these tests: Mesa's driver for the CPU with the validation layer, or the one that
// HALFLIGHT_TEST_DEVICE names.

#include "halflight/bake_gpu/gpu_integrator.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

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

} // namespace halflight::test
