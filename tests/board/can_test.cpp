// hal/linux/can/can_socket.hpp on the kernel's own CAN, with can-utils as the other side. Runs in a
// guest.

#include <functional>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <string>

#include "hal/linux/can/can_socket.hpp"
#include "shell.hpp"

namespace smaservo {
namespace {

constexpr std::uint32_t node_id = 0x123;

hal::CanFrame some_frame() {
  hal::CanFrame frame;
  frame.id = 0x581;
  frame.length = 3;
  frame.data = {0xca, 0xfe, 0x01};
  return frame;
}

/// A frame within a second, as the kernel hands it over.
bool wait_for(hal::CanSocket& port, hal::CanFrame& frame) {
  for (int tries = 0; tries < 10; ++tries) {
    if (port.receive(frame)) {
      return true;
    }
    pollfd readable{port.descriptor(), POLLIN, 0};
    poll(&readable, 1, 100);
  }
  return port.receive(frame);
}

/// What candump sees on this interface while `act` runs; it is there before.
std::string dump_while(const std::string& interface, const std::function<void()>& act) {
  const std::string listeners = "$(grep -c '^ *" + interface + " ' /proc/net/can/rcvlist_all)";
  run("n=" + listeners + "; candump -T 2000 -n 1 " + interface +
      " >/tmp/dump 2>&1 & echo $! >/tmp/candump; while [ " + listeners +
      " -le $n ]; do sleep 0.01; done");
  act();
  run("while kill -0 $(cat /tmp/candump) 2>/dev/null; do sleep 0.01; done");
  return run("tr -s ' ' </tmp/dump");
}

class Can : public testing::Test {
 protected:
  void SetUp() override {
    run("/usr/sbin/ip link add vcan0 type vcan 2>/dev/null; /usr/sbin/ip link set vcan0 up");
  }
  void TearDown() override { run("/usr/sbin/ip link del vcan0 2>/dev/null || true"); }
};

TEST_F(Can, FramesComeFromOutside) {
  hal::CanSocket port("vcan0");
  run("cansend vcan0 123#DEADBEEF");
  hal::CanFrame frame;
  ASSERT_TRUE(wait_for(port, frame));
  EXPECT_EQ(frame.id, node_id);
  EXPECT_EQ(frame.length, 4);
  EXPECT_EQ(frame.data, (std::array<std::uint8_t, 8>{0xde, 0xad, 0xbe, 0xef}));
}

TEST_F(Can, FramesGoOutAndDoNotComeBack) {
  hal::CanSocket port("vcan0");
  EXPECT_EQ(dump_while("vcan0", [&] { EXPECT_TRUE(port.send(some_frame())); }),
            " vcan0 581 [3] CA FE 01\n");
  hal::CanFrame frame;
  EXPECT_FALSE(port.receive(frame));
}

TEST_F(Can, TheKernelSortsOutOtherIdentifiers) {
  hal::CanSocket port("vcan0");
  constexpr std::array<std::uint32_t, 2> ids{0x000, node_id};
  port.accept(ids);
  run("cansend vcan0 122#01; cansend vcan0 00000123#02; cansend vcan0 123#R; cansend vcan0 123#03");
  hal::CanFrame frame;
  ASSERT_TRUE(wait_for(port, frame));
  EXPECT_EQ(frame.data[0], 3);
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.statistics().received, 1U);
}

TEST_F(Can, InterfaceGoesDownAndComesUp) {
  hal::CanSocket port("vcan0");
  hal::CanFrame frame;
  run("/usr/sbin/ip link set vcan0 down");
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.state(), hal::CanState::down);
  EXPECT_FALSE(port.send(some_frame()));
  EXPECT_GE(port.statistics().dropped_down, 1U);
  EXPECT_EQ(port.statistics().downs, 1U);
  run("/usr/sbin/ip link set vcan0 up");
  EXPECT_EQ(dump_while("vcan0", [&] { EXPECT_TRUE(port.send(some_frame())); }),
            " vcan0 581 [3] CA FE 01\n");
  EXPECT_EQ(port.state(), hal::CanState::active);
  run("cansend vcan0 123#07");
  ASSERT_TRUE(wait_for(port, frame));
  EXPECT_EQ(frame.data[0], 7);
}

TEST_F(Can, InterfaceDisappearsAndComesBack) {
  hal::CanSocket port("vcan0");
  constexpr std::array<std::uint32_t, 1> ids{node_id};
  port.accept(ids);
  run("/usr/sbin/ip link del vcan0");
  EXPECT_FALSE(port.send(some_frame()));
  EXPECT_EQ(port.state(), hal::CanState::gone);
  run("/usr/sbin/ip link add vcan0 type vcan; /usr/sbin/ip link set vcan0 up");
  hal::CanFrame frame;
  EXPECT_FALSE(port.receive(frame));
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.state(), hal::CanState::active);
  EXPECT_GE(port.statistics().reopens, 1U);
  run("cansend vcan0 122#01; cansend vcan0 123#09");
  ASSERT_TRUE(wait_for(port, frame));
  EXPECT_EQ(frame.data[0], 9) << "filters of the interface that was";
}

TEST_F(Can, ErrorFramesTellBusOffAndRestart) {
  hal::CanSocket port("vcan0");
  hal::CanFrame frame;
  run("cansend vcan0 20000004#0010000000000000");  // error-passive while receiving
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.state(), hal::CanState::passive);
  run("cansend vcan0 20000040#0000000000000000");
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.state(), hal::CanState::bus_off);
  EXPECT_EQ(port.statistics().bus_offs, 1U);
  run("cansend vcan0 20000100#0000000000000000");
  EXPECT_FALSE(port.receive(frame));
  EXPECT_EQ(port.state(), hal::CanState::active);
  EXPECT_EQ(port.statistics().error_frames, 3U);
}

TEST_F(Can, NamesWhatItCanNotOpen) {
  EXPECT_THROW(hal::CanSocket("vcan7"), hal::CanError);
  try {
    const hal::CanSocket port("lo");
    FAIL() << port.name();
  } catch (const hal::CanError& error) {
    EXPECT_STREQ(error.what(), "lo: is no CAN interface");
  }
}

// Two controllers of real silicon's driver (SJA1000 on PCI) on one bus that qemu emulates.
TEST(CanController, FramesGoBothWays) {
  for (const char* interface : {"can0", "can1"}) {
    run("/usr/sbin/ip link set " + std::string(interface) +
        " up type can bitrate 500000 restart-ms 100");
  }
  hal::CanSocket port("can0");
  EXPECT_EQ(dump_while("can1", [&] { EXPECT_TRUE(port.send(some_frame())); }),
            " can1 581 [3] CA FE 01\n");
  run("cansend can1 123#0102030405060708");
  hal::CanFrame frame;
  ASSERT_TRUE(wait_for(port, frame));
  EXPECT_EQ(frame.length, 8);
  EXPECT_EQ(frame.data[7], 8);
  EXPECT_EQ(port.state(), hal::CanState::active);
  run("/usr/sbin/ip link set can0 down");
  EXPECT_FALSE(port.send(some_frame()));
  EXPECT_EQ(port.state(), hal::CanState::down);
}

// The controller's interrupt waits for a processor that is busy sending: one frame is under way,
// ten wait in the queue.
TEST(CanController, AFullQueueRefusesAndWaitsForNobody) {
  for (const char* interface : {"can0", "can1"}) {
    run("/usr/sbin/ip link set " + std::string(interface) + " down; /usr/sbin/ip link set " +
        interface + " up type can bitrate 500000");
  }
  hal::CanSocket port("can0");
  const sched_param above{.sched_priority = 90};
  const sched_param ordinary{.sched_priority = 0};
  ASSERT_EQ(sched_setscheduler(0, SCHED_FIFO, &above), 0);
  constexpr int frames = 50;
  int refused = 0;
  for (int i = 0; i < frames; ++i) {
    refused += port.send(some_frame()) ? 0 : 1;
  }
  ASSERT_EQ(sched_setscheduler(0, SCHED_OTHER, &ordinary), 0);
  // Ten are in the queue, one or two are the controller's.
  EXPECT_LE(frames - 12, refused);
  EXPECT_LE(refused, frames - 11);
  EXPECT_EQ(port.statistics().dropped_full, static_cast<std::uint64_t>(refused));
  EXPECT_EQ(port.state(), hal::CanState::active);
  run("sleep 0.1");
  EXPECT_TRUE(port.send(some_frame())) << "it has emptied";
}

}  // namespace
}  // namespace smaservo
