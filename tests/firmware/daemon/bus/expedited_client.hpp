#pragma once
// A client of node 1: expedited SDO, NMT, LSS.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "firmware/canopen/node/object.hpp"
#include "hal/can_frame.hpp"

namespace smaservo::test {

/// `Link` sends frames, and waits for the next one with an identifier.
template <class Link>
class ExpeditedClient {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  template <class... Arguments>
  explicit ExpeditedClient(Arguments&&... arguments)
      : link_(std::forward<Arguments>(arguments)...) {}

  void send(std::uint32_t id, std::uint8_t length, const Bytes& data) {
    link_.send({.id = id, .length = length, .data = data});
  }
  void nmt(std::uint8_t command) { send(0, 2, {command, 1}); }
  /// The next frame with this identifier; those before it are forgotten. None: it never comes.
  std::optional<hal::CanFrame> wait(std::uint32_t id) { return link_.wait(id); }

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
  /// Writes an object of `size` bytes. Returns Abort::none, or the abort code of the answer.
  canopen::Abort set(Key key, std::uint32_t value, unsigned size = 4) {
    const Bytes answer = ask(static_cast<std::uint8_t>(0x23U | (4U - size) << 2U), key, value);
    return answer[0] == 0x60 ? canopen::Abort::none
                             : static_cast<canopen::Abort>(number_of(answer));
  }

  Link& link() { return link_; }

 private:
  static std::uint32_t number_of(const Bytes& answer) {
    return static_cast<std::uint32_t>(canopen::take_number(std::span(answer).subspan(4)));
  }

  Link link_;
};

}  // namespace smaservo::test
