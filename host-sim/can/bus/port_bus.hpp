#pragma once

#include "hal/linux/can/open_can.hpp"
#include "host-sim/can/bus/bus.hpp"

namespace smaservo::can {

/// An interface or multicast group of this machine, in real time.
class PortBus final : public Bus {
 public:
  /// `name` as for open_can(). Throws UserError.
  explicit PortBus(const std::string& name);

  void send(const hal::CanFrame& frame) override;
  bool receive(hal::CanFrame& frame, std::int64_t until_us) override;
  std::int64_t now_us() const override;
  std::string name() const override { return port_.name(); }
  hal::CanState state() const { return port_.state(); }

 private:
  hal::LinuxCan port_;
};

}  // namespace smaservo::can
