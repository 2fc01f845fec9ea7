// Answers each data frame of a bus with its bytes in reverse order under the next identifier, and
// each remote frame with one that asks back; ends with the identifier 7F0h. A partner for clients.

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <poll.h>

#include "hal/linux/can/open_can.hpp"

namespace smaservo {
namespace {

constexpr std::uint32_t last_id = 0x7F0;
constexpr int patience_ms = 600'000;

hal::CanFrame mirrored(hal::CanFrame frame) {
  ++frame.id;
  std::reverse(frame.data.begin(), frame.data.begin() + frame.length);
  return frame;
}

int run(const char* name) {
  hal::LinuxCan port = hal::open_can(name);
  fmt::print("ready\n");
  std::fflush(stdout);
  pollfd waiting{port.descriptor(), POLLIN, 0};
  while (poll(&waiting, 1, patience_ms) > 0) {
    hal::CanFrame frame;
    while (port.receive(frame)) {
      if (frame.id == last_id) {
        return 0;
      }
      port.send(mirrored(frame));
    }
  }
  fmt::print(stderr, "mirror: nothing came for {} s\n", patience_ms / 1000);
  return 1;
}

}  // namespace
}  // namespace smaservo

int main(int argc, char** argv) {
  try {
    return argc == 2 ? smaservo::run(argv[1]) : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "mirror: {}\n", error.what());
    return 1;
  }
}
