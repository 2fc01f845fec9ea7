#pragma once
// Switches axes off from any thread at once, by a bus port of its own: whatever the bus's thread is
// doing, the frames go out before this returns.

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

  /// Controlword 0 to each of these nodes, by RPDO1 where that carries it, and by SDO, which ends
  /// any transfer. A bus that takes no frames is told elsewhere.
  void off(const NodeSet& nodes);
  /// RPDO1 of this node carries controlword and mode, and the mode is this one.
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
