#pragma once
// A client on a multicast group of this machine alone.

#include <fmt/format.h>
#include <poll.h>
#include <string>
#include <unistd.h>

#include "hal/linux/can/open_can.hpp"
#include "tests/firmware/daemon/bus/expedited_client.hpp"
#include "tests/patience.hpp"

namespace smaservo::test {

class MulticastLink {
 public:
  /// Tests run beside each other.
  static std::string name() {
    return fmt::format("udp:239.74.163.3%lo:{}", 20000 + getpid() % 20000);
  }

  void send(const hal::CanFrame& frame) { port_.send(frame); }
  std::optional<hal::CanFrame> wait(std::uint32_t id) {
    using Clock = std::chrono::steady_clock;
    for (const auto until = Clock::now() + patience; Clock::now() < until;) {
      hal::CanFrame frame;
      while (port_.receive(frame)) {
        boot_ups_ += frame.id == 0x701 && frame.length == 1 && frame.data[0] == 0 ? 1 : 0;
        if (frame.id == id) {
          return frame;
        }
      }
      pollfd readable{port_.descriptor(), POLLIN, 0};
      poll(&readable, 1, 1000);
    }
    return {};
  }
  /// Of node 1, among the frames that have been seen.
  int boot_ups() const { return boot_ups_; }

 private:
  hal::LinuxCan port_ = hal::open_can(name());
  int boot_ups_ = 0;
};

using BusClient = ExpeditedClient<MulticastLink>;

}  // namespace smaservo::test
