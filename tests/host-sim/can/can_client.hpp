#pragma once
// A client of a simulated servo on a simulated bus.

#include <gmock/gmock.h>
#include <string>

#include "host-sim/can/settings.hpp"
#include "model/files/error.hpp"
#include "tests/host-sim/can/simulated_bus.hpp"

namespace smaservo::can {

inline constexpr Key gain{0x2100, 1};

inline Bytes real_bytes(float value) {
  Bytes bytes(4);
  canopen::put_number(bytes, canopen::as_bits(value));
  return bytes;
}

struct CanClient : testing::Test {
  test::SimulatedBus bus;
  SdoClient client{bus, test::SimulatedBus::node};
  Remote remote{client};

  void run(double seconds) {
    hal::CanFrame passing;
    const std::int64_t until_us = bus.now_us() + static_cast<std::int64_t>(seconds * 1e6);
    while (bus.receive(passing, until_us)) {
    }
  }
  static Change change(const char* name, const char* value) {
    const text::KnownObject object = text::find_object(name);
    return {object, text::value_bytes(object, value)};
  }
  template <class F>
  static std::string refusal(F f) {
    try {
      f();
    } catch (const files::UserError& error) {
      return error.what();
    }
    return "";
  }
};

}  // namespace smaservo::can
