#include "host-sim/page/servos/traffic/off_switch.hpp"

#include <span>

#include "firmware/canopen/node/object.hpp"
#include "model/files/error.hpp"

namespace smaservo::page {

void OffSwitch::off(const NodeSet& nodes) {
  const std::scoped_lock lock(mutex_);
  for (unsigned node = 1; node < nodes.size(); ++node) {
    if (!nodes[node]) {
      continue;
    }
    try {
      off(node);
    } catch (const files::UserError&) {
      return;  // the check that follows reports that the bus does not work
    }
  }
  // Frames that this port has received meanwhile are dropped: the other port receives them, too.
  hal::CanFrame frame;
  for (int i = 0; i < 1000 && bus_->receive(frame, 0); ++i) {
  }
}

void OffSwitch::off(unsigned node) {
  const int mode = mode_[node];
  if (mode != none) {
    bus_->send({.id = 0x200 + node, .length = 3, .data = {0, 0, static_cast<std::uint8_t>(mode)}});
  }
  constexpr std::uint32_t general_error = 0x0800'0000;
  hal::CanFrame abort{.id = 0x600 + node, .length = 8, .data = {0x80}};
  canopen::put_number(std::span(abort.data).subspan(4), general_error);
  bus_->send(abort);
  bus_->send({.id = 0x600 + node, .length = 8, .data = {0x2B, 0x40, 0x60}});
}

}  // namespace smaservo::page
