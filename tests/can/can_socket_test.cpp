// Needs a kernel with CAN, vcan0 and the right to change interfaces: runs in a guest
// (toolchain/can/uml).

#include "hal/linux/can/can_socket.hpp"

#include <cstdlib>
#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>

#include "hal/linux/can/open_can.hpp"
#include "tests/patience.hpp"

namespace smaservo {
namespace {

void shell(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(bugprone-command-processor)
}

/// Waits for a frame.
bool next(hal::CanSocket& port, hal::CanFrame& frame) {
  return test::becomes([&] { return port.receive(frame); });
}

/// Looks at the port until it is in this state.
bool becomes(hal::CanSocket& port, hal::CanState state) {
  return test::becomes([&] {
    hal::CanFrame frame;
    return port.state() == state || (port.receive(frame), port.state() == state);
  });
}

constexpr hal::CanFrame hello{.id = 0x123, .length = 3, .data = {1, 2, 3}};

std::string refusal(const std::string& name) {
  try {
    hal::open_can(name);
  } catch (const hal::CanError& error) {
    return error.what();
  }
  return "";
}

TEST(CanSocket, SaysWhyItCanNotBeOpened) {
  EXPECT_EQ(refusal("can7"), "can7: no such interface");
  EXPECT_EQ(refusal("lo"), "lo: is no CAN interface");
  EXPECT_EQ(refusal("vcan0"), "");
}

TEST(CanSocket, OthersHearAndTheSenderDoesNot) {
  hal::CanSocket one("vcan0");
  hal::CanSocket other("vcan0");
  hal::CanSocket elsewhere("vcan1");
  const hal::CanFrame frames[] = {
      hello,
      {.id = 0x1ABCDEF0, .extended = true, .length = 8, .data = {8, 7, 6, 5, 4, 3, 2, 1}},
      {.id = 0x701, .remote = true, .length = 4},
      {.id = 0},
  };
  for (const hal::CanFrame& frame : frames) {
    ASSERT_TRUE(one.send(frame));
    hal::CanFrame got;
    ASSERT_TRUE(next(other, got));
    EXPECT_EQ(got, frame);
    EXPECT_FALSE(one.receive(got));
    EXPECT_FALSE(elsewhere.receive(got));
  }
  EXPECT_EQ(one.statistics().sent, 4U);
  EXPECT_EQ(other.statistics().received, 4U);
}

TEST(CanSocket, AcceptsOnlyDataFramesWithTheseIdentifiers) {
  hal::CanSocket sender("vcan0");
  hal::CanSocket port("vcan0");
  const std::uint32_t ids[] = {0x000, 0x123, 0x601};
  port.accept(ids);
  for (const hal::CanFrame& other :
       {hal::CanFrame{.id = 0x124}, hal::CanFrame{.id = 0x123, .extended = true},
        hal::CanFrame{.id = 0x123, .remote = true}, hal::CanFrame{.id = 0x723}}) {
    ASSERT_TRUE(sender.send(other));
  }
  for (const std::uint32_t id : ids) {
    ASSERT_TRUE(sender.send({.id = id}));
    hal::CanFrame got;
    ASSERT_TRUE(next(port, got));
    EXPECT_EQ(got, hal::CanFrame{.id = id});
  }
}

TEST(CanSocket, OutlivesAnInterfaceThatGoesDown) {
  hal::CanSocket port("vcan0");
  hal::CanSocket other("vcan0");
  shell("ip link set vcan0 down");
  EXPECT_FALSE(port.send(hello));
  EXPECT_TRUE(becomes(other, hal::CanState::down));
  EXPECT_EQ(port.state(), hal::CanState::down);
  EXPECT_EQ(port.statistics().dropped_down, 1U);
  shell("ip link set vcan0 up");
  EXPECT_TRUE(port.send(hello));
  hal::CanFrame got;
  EXPECT_TRUE(next(other, got));
  EXPECT_TRUE(becomes(other, hal::CanState::active));
  EXPECT_EQ(port.statistics().downs, 1U);
  EXPECT_EQ(other.statistics().downs, 1U);
}

TEST(CanSocket, StartsOnAnInterfaceThatIsDown) {
  shell("ip link set vcan0 down");
  hal::CanSocket port("vcan0");
  EXPECT_EQ(port.state(), hal::CanState::down);
  EXPECT_FALSE(port.send(hello));
  shell("ip link set vcan0 up");
  EXPECT_TRUE(port.send(hello));
  EXPECT_TRUE(becomes(port, hal::CanState::active));
}

TEST(CanSocket, ComesBackWithItsInterfaceAndItsFilters) {
  shell("ip link add vcan7 type vcan && ip link set vcan7 up");
  hal::CanSocket port("vcan7");
  const int descriptor = port.descriptor();
  const std::uint32_t ids[] = {0x123};
  port.accept(ids);
  for (int i = 1; i <= 3; ++i) {
    shell("ip link delete vcan7");
    EXPECT_TRUE(becomes(port, hal::CanState::gone));
    EXPECT_FALSE(port.send(hello));
    shell("ip link add vcan7 type vcan && ip link set vcan7 up");
    EXPECT_TRUE(port.send(hello));
    hal::CanSocket other("vcan7");
    EXPECT_TRUE(other.send({.id = 0x124}));
    EXPECT_TRUE(other.send(hello));
    hal::CanFrame got;
    ASSERT_TRUE(next(port, got));
    EXPECT_EQ(got, hello);
    EXPECT_FALSE(port.receive(got));
    EXPECT_EQ(port.state(), hal::CanState::active);
    EXPECT_EQ(port.statistics().reopens, static_cast<std::uint64_t>(i));
  }
  // It went and came while nobody looked.
  shell("ip link delete vcan7 && ip link add vcan7 type vcan && ip link set vcan7 up");
  EXPECT_TRUE(becomes(port, hal::CanState::gone) || port.send(hello));
  EXPECT_TRUE(becomes(port, hal::CanState::active));
  EXPECT_EQ(port.descriptor(), descriptor);
  shell("ip link delete vcan7");
}

// What the kernel still has to say of the interface that was does not make the new one disappear.
TEST(CanSocket, AnInterfaceThatComesBackDownHasGoneOnce) {
  shell("ip link add vcan7 type vcan && ip link set vcan7 up");
  hal::CanSocket port("vcan7");
  shell("ip link delete vcan7");
  EXPECT_FALSE(port.send(hello));  // leaves the error to be read
  shell("ip link add vcan7 type vcan");
  hal::CanFrame got;
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(port.receive(got));
    EXPECT_FALSE(port.send(hello));
    EXPECT_NE(port.state(), hal::CanState::active);
  }
  EXPECT_EQ(port.state(), hal::CanState::down);
  shell("ip link set vcan7 up");
  EXPECT_TRUE(port.send(hello));
  EXPECT_EQ(port.statistics().downs, 1U);
  EXPECT_EQ(port.statistics().reopens, 1U);
  shell("ip link delete vcan7");
}

/// As a controller's driver reports it.
void inject(std::uint32_t classes, const char* data) {
  std::array<char, 80> command;
  std::snprintf(command.data(), command.size(), "cansend vcan0 %08X#%s", classes | CAN_ERR_FLAG,
                data);
  shell(command.data());
}

TEST(CanSocket, FollowsTheControllersErrorStates) {
  hal::CanSocket port("vcan0");
  hal::CanFrame frame;
  inject(CAN_ERR_CRTL, "0020000000000000");
  EXPECT_TRUE(becomes(port, hal::CanState::passive));
  inject(CAN_ERR_CRTL, "0040000000000000");
  EXPECT_TRUE(becomes(port, hal::CanState::active));
  inject(CAN_ERR_BUSOFF, "0000000000000000");
  EXPECT_TRUE(becomes(port, hal::CanState::bus_off));
  inject(CAN_ERR_RESTARTED, "0000000000000000");
  EXPECT_TRUE(becomes(port, hal::CanState::active));
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.statistics().error_frames, 4U);
  EXPECT_EQ(port.statistics().bus_offs, 1U);
  EXPECT_EQ(port.statistics().received, 0U);
}

// A queue that is full, here that of the receiver.
TEST(CanSocket, CountsWhatItWasTooSlowFor) {
  hal::CanSocket sender("vcan0");
  hal::CanSocket port("vcan0");
  constexpr std::uint64_t sent = 5000;
  for (std::uint64_t i = 0; i < sent; ++i) {
    ASSERT_TRUE(sender.send(hello));
  }
  hal::CanFrame got;
  std::uint64_t received = 0;
  while (port.receive(got)) {
    ++received;
  }
  ASSERT_TRUE(sender.send(hello));
  ASSERT_TRUE(next(port, got));
  EXPECT_LT(received, sent);
  EXPECT_EQ(received + port.statistics().lost, sent);
}

}  // namespace
}  // namespace smaservo
