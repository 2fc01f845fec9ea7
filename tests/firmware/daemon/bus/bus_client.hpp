#pragma once
// A client on a multicast group of this machine alone: expedited SDO, NMT, LSS.

#include <array>
#include <chrono>
#include <fmt/format.h>
#include <optional>
#include <poll.h>
#include <string>
#include <unistd.h>

#include "firmware/canopen/node/object.hpp"
#include "hal/linux/can/open_can.hpp"

namespace smaservo::test {

class BusClient {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// Tests run beside each other.
  static std::string name() {
    return fmt::format("udp:239.74.163.3%lo:{}", 20000 + getpid() % 20000);
  }

  void send(std::uint32_t id, std::uint8_t length, const Bytes& data) {
    port_.send({.id = id, .length = length, .data = data});
  }
  void nmt(std::uint8_t command) { send(0, 2, {command, 1}); }

  /// The next frame with this identifier, within so long.
  std::optional<hal::CanFrame> wait(std::uint32_t id, int milliseconds = 5000) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + std::chrono::milliseconds(milliseconds);
    for (;;) {
      hal::CanFrame frame;
      while (port_.receive(frame)) {
        if (frame.id == id) {
          return frame;
        }
      }
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
      if (left <= 0) {
        return {};
      }
      pollfd readable{port_.descriptor(), POLLIN, 0};
      poll(&readable, 1, static_cast<int>(left));
    }
  }

  /// The answer's bytes; all FFh: none came.
  Bytes ask(std::uint8_t command, Key key, std::uint32_t value = 0) {
    Bytes request{command, static_cast<std::uint8_t>(key.index),
                  static_cast<std::uint8_t>(key.index >> 8U), key.sub};
    canopen::put_number(std::span(request).subspan(4), value);
    send(0x601, 8, request);
    constexpr Bytes silence{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    const auto answer = wait(0x581);
    return answer ? answer->data : silence;
  }
  std::uint32_t get(Key key) { return number_of(ask(0x40, key)); }
  /// Of four bytes: none, or the abort.
  canopen::Abort set(Key key, std::uint32_t value, unsigned size = 4) {
    const Bytes answer = ask(static_cast<std::uint8_t>(0x23U | (4U - size) << 2U), key, value);
    return answer[0] == 0x60 ? canopen::Abort::none
                             : static_cast<canopen::Abort>(number_of(answer));
  }

 private:
  static std::uint32_t number_of(const Bytes& answer) {
    return static_cast<std::uint32_t>(canopen::take_number(std::span(answer).subspan(4)));
  }

  hal::LinuxCan port_ = hal::open_can(name());
};

}  // namespace smaservo::test
