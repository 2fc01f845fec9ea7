#include "tests/mcu/checks.hpp"

#include <gtest/gtest.h>
#include <string>

#include "firmware/parameters/parameters.hpp"
#include "tests/firmware/device/test_device.hpp"

namespace smaservo::mcu {
namespace {

class McuCheck : public testing::TestWithParam<Check> {};

TEST_P(McuCheck, HoldsHere) {
  Verdict verdict;
  GetParam().run(stored_settings<float>(test_settings<float>()), verdict);
  EXPECT_EQ(verdict.broken, "");
}

INSTANTIATE_TEST_SUITE_P(All, McuCheck, testing::ValuesIn(checks().begin(), checks().end()),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace smaservo::mcu
