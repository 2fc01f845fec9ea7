#pragma once
// Switches axes off at once, from any thread. It has a bus port of its own, so that it sends its
// frames before it returns, whatever the bus's thread is doing.

#include <array>
#include <atomic>
#include <memory>
#include <mutex>

#include "host-sim/can/bus/bus.hpp"
#include "host-sim/page/servos/control.hpp"

namespace smaservo::page {

class OffSwitch {
 public:
  explicit OffSwitch(std::unique_ptr<can::Bus> bus) : bus_(std::move(bus)) {}

  /// Sends controlword 0 to each of these nodes, by RPDO1 if that carries it, and by SDO, which
  /// ends any transfer. A bus that accepts no frames is reported elsewhere.
  void off(const NodeSet& nodes);
  /// Notes that RPDO1 of this node carries controlword and mode, and that the mode is this one.
  void knows_pdo(unsigned node, int mode) { mode_[node] = mode; }
  void knows_no_pdo(unsigned node) { mode_[node] = none; }

 private:
  static constexpr int none = 1000;

  void off(unsigned node);

  std::mutex mutex_;
  std::unique_ptr<can::Bus> bus_;
  std::array<std::atomic<int>, 128> mode_{};
};

}  // namespace smaservo::page
