// Datagrams between sockets: when they come is the kernel's.

#include "hal/linux/can/can_multicast.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/patience.hpp"

namespace smaservo::can_multicast_live_test {
namespace {

/// Of this machine alone.
constexpr const char* group = "239.74.163.2%lo";

/// Tests run beside each other.
std::uint16_t own_port() {
  return static_cast<std::uint16_t>(20000 + getpid() % 20000);
}

/// Waits for a frame.
bool next(hal::CanMulticast& port, hal::CanFrame& frame) {
  return test::becomes([&] { return port.receive(frame); });
}

constexpr hal::CanFrame hello{.id = 0x123, .length = 3, .data = {1, 2, 3}};
constexpr hal::CanFrame answer{.id = 0x124, .length = 1, .data = {9}};

TEST(CanMulticast, OthersHearAndTheSenderDoesNot) {
  hal::CanMulticast one(group, own_port());
  hal::CanMulticast other(group, own_port());
  hal::CanMulticast third(group, own_port());
  ASSERT_TRUE(one.send(hello));
  ASSERT_TRUE(other.send(answer));
  hal::CanFrame frame;
  ASSERT_TRUE(next(third, frame));
  EXPECT_EQ(frame, hello);
  ASSERT_TRUE(next(third, frame));
  EXPECT_EQ(frame, answer);
  ASSERT_TRUE(next(one, frame));
  EXPECT_EQ(frame, answer);
  ASSERT_TRUE(next(other, frame));
  EXPECT_EQ(frame, hello);
  EXPECT_FALSE(one.receive(frame));
  EXPECT_FALSE(other.receive(frame));
  EXPECT_EQ(one.statistics().sent, 1U);
  EXPECT_EQ(one.statistics().received, 1U);
}

TEST(CanMulticast, CountsWhatIsNoFrame) {
  hal::CanMulticast port(group, own_port());
  hal::CanMulticast sender(group, own_port());
  const hal::MulticastAddress address = hal::multicast_address(group, own_port());
  const hal::Descriptor raw(socket(AF_INET, SOCK_DGRAM, 0));
  const std::string texts[] = {"", "nonsense", std::string(5000, '\x81')};
  for (const std::string& text : texts) {
    const auto* to = reinterpret_cast<const sockaddr*>(&address.address);
    // Over the loopback interface, as the port's group says.
    ip_mreqn interface{};
    interface.imr_ifindex = static_cast<int>(address.interface);
    ASSERT_EQ(setsockopt(raw.number(), IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface),
              0);
    ASSERT_EQ(sendto(raw.number(), text.data(), text.size(), 0, to, address.size),
              static_cast<ssize_t>(text.size()));
  }
  ASSERT_TRUE(sender.send(hello));
  hal::CanFrame frame;
  ASSERT_TRUE(next(port, frame));
  EXPECT_EQ(frame, hello);
  EXPECT_EQ(port.statistics().malformed, 3U);
}

}  // namespace
}  // namespace smaservo::can_multicast_live_test
