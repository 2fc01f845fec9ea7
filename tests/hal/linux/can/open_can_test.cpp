#include "hal/linux/can/open_can.hpp"

#include <gmock/gmock.h>

namespace smaservo::open_can_test {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    hal::open_can(text);
  } catch (const hal::CanError& error) {
    return error.what();
  }
  return "";
}

TEST(OpenCan, TakesGroupsWithAndWithoutAPort) {
  EXPECT_EQ(hal::open_can("udp:239.74.163.2%lo").name(), "udp:239.74.163.2%lo:43113");
  EXPECT_EQ(hal::open_can("udp:239.74.163.2%lo:5000").name(), "udp:239.74.163.2%lo:5000");
}

TEST(OpenCan, SaysWhatIsWrong) {
  EXPECT_EQ(refusal("udp:239.74.163.2:0"), "udp: port 0: must be a number from 1 to 65535");
  EXPECT_EQ(refusal("udp:239.74.163.2:70000"), "udp: port 70000: must be a number from 1 to 65535");
  EXPECT_EQ(refusal("udp:239.74.163.2:x"), "udp: port x: must be a number from 1 to 65535");
  EXPECT_EQ(refusal("udp:[ff15::1"), "udp:[ff15::1: must be udp:[GROUP]:PORT");
  EXPECT_EQ(refusal("udp:[ff15::1%nowhere]:5000"), "ff15::1%nowhere: no interface nowhere");
  EXPECT_EQ(refusal("udp:ff15::1%nowhere"), "ff15::1%nowhere: no interface nowhere");
  EXPECT_EQ(refusal(""), "CAN interface \"\": a name has 1 to 15 characters");
  EXPECT_THAT(refusal("a-name-that-is-too-long"), HasSubstr("a name has 1 to 15 characters"));
  // Kernels without CAN say so before they look for the interface.
  EXPECT_THAT(refusal("nowhere7"), HasSubstr("nowhere7: "));
}

}  // namespace
}  // namespace smaservo::open_can_test
