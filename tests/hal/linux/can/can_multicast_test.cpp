#include "hal/linux/can/can_multicast.hpp"

#include <gtest/gtest.h>

namespace smaservo::can_multicast_test {
namespace {

std::string refusal(const std::string& text) {
  try {
    hal::multicast_address(text, hal::default_multicast_port);
  } catch (const hal::CanError& error) {
    return error.what();
  }
  return "";
}

TEST(CanMulticast, SaysWhatIsWrongWithAGroup) {
  EXPECT_EQ(refusal("192.168.1.1"),
            "192.168.1.1: is no multicast group: 224.0.0.0 to 239.255.255.255 or ff00::/8");
  EXPECT_EQ(refusal("fe80::1"),
            "fe80::1: is no multicast group: 224.0.0.0 to 239.255.255.255 or ff00::/8");
  EXPECT_EQ(refusal("somewhere"), "somewhere: is no multicast group of IPv4 or IPv6");
  EXPECT_EQ(refusal("239.1.2.3%nowhere"), "239.1.2.3%nowhere: no interface nowhere");
  EXPECT_EQ(refusal(hal::default_multicast_group), "");
}

}  // namespace
}  // namespace smaservo::can_multicast_test
