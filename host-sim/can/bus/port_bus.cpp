#include "host-sim/can/bus/port_bus.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <poll.h>

#include "model/files/error.hpp"

namespace smaservo::can {
namespace {

/// Number of attempts, a millisecond apart, to put a frame into a full queue. The queue empties
/// within the time of a few frames unless no node acknowledges them.
constexpr int queue_tries = 200;

hal::LinuxCan opened(const std::string& name) {
  try {
    return hal::open_can(name);
  } catch (const hal::CanError& error) {
    throw files::UserError(error.what());
  }
}

}  // namespace

PortBus::PortBus(const std::string& name) : port_(opened(name)) {}

void PortBus::send(const hal::CanFrame& frame) {
  for (int i = 0; i < queue_tries; ++i) {
    if (port_.send(frame)) {
      return;
    }
    if (port_.state() == hal::CanState::down || port_.state() == hal::CanState::gone) {
      throw files::UserError(
          fmt::format("{}: the interface is {}", name(), hal::name(port_.state())));
    }
    poll(nullptr, 0, 1);
  }
  throw files::UserError(
      fmt::format("{}: the queue stays full: no node acknowledges frames; is the cable connected "
                  "and terminated, and is the bit rate the same everywhere?",
                  name()));
}

bool PortBus::receive(hal::CanFrame& frame, std::int64_t until_us) {
  for (;;) {
    if (port_.receive(frame)) {
      return true;
    }
    const std::int64_t left_us = until_us - now_us();
    if (left_us <= 0) {
      return false;
    }
    if (port_.state() == hal::CanState::bus_off) {
      throw files::UserError(
          fmt::format("{}: the controller is bus-off; `ip link set {} type can "
                      "restart` starts it again",
                      name(), name()));
    }
    pollfd waiting{port_.descriptor(), POLLIN, 0};
    // ppoll() instead of poll(), whose milliseconds are too coarse for sending SYNC each
    // millisecond.
    const std::int64_t wait_us = std::min<std::int64_t>(left_us, 1'000'000);
    // Both members have 32 bits on armhf.
    const timespec wait{static_cast<time_t>(wait_us / 1'000'000),
                        static_cast<long>(wait_us % 1'000'000 * 1000)};
    ppoll(&waiting, 1, &wait, nullptr);
  }
}

std::int64_t PortBus::now_us() const {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace smaservo::can
