#include "host-sim/page/servos/traffic/shared_bus.hpp"

#include <algorithm>

namespace smaservo::page {

void SharedBus::send(const hal::CanFrame& frame) {
  throw_if_interrupted();
  bus_.send(frame);
  traffic_.said(frame, bus_.now_us());
}

bool SharedBus::receive(hal::CanFrame& frame, std::int64_t until_us) {
  for (;;) {
    throw_if_interrupted();
    std::int64_t now_us = bus_.now_us();
    std::int64_t next_us = until_us;
    if (now_us < until_us) {
      next_us = std::min(until_us, traffic_.tick(now_us));
    }
    if (bus_.receive(frame, next_us)) {
      traffic_.heard(frame, bus_.now_us());
      return true;
    }
    now_us = bus_.now_us();
    if (until_us <= now_us) {
      return false;
    }
  }
}

/// Waits for the answer to a request of the traffic before a client's transfer begins. A node's SDO
/// server has one transfer at a time: a new request drops the answer to the one before.
void SharedBus::transfer(unsigned node, bool goes_on) {
  if (goes_on) {
    hal::CanFrame frame;
    while (traffic_.waits_for(node, bus_.now_us())) {
      throw_if_interrupted();
      if (bus_.receive(frame, bus_.now_us() + 1000)) {
        traffic_.heard(frame, bus_.now_us());
      }
    }
  }
  busy_.set(node, goes_on);
}

}  // namespace smaservo::page
