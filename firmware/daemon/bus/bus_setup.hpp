#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/daemon/loop/links.hpp"

namespace smaservo::daemon {

struct BusSetup {
  std::string interface;  ///< "can0", or "udp", "udp:GROUP", "udp:GROUP:PORT"
  double lost_after_s = 0;
  std::string folder;  ///< folder of the store; empty: nothing can be stored
  canopen::Ceilings ceilings;
  canopen::AccessKeys keys;
  bool unattended = false;  ///< heat may go on without anybody who commands
  std::string board;        ///< its name in 1009h
  int priority = 0;         ///< the thread's, in SCHED_FIFO; 0: none
  /// For the change log: what the store may have lost.
  // g++ warns of what designated initializers leave out, unless it has one of its own.
  std::vector<LostValue> lost = {};  // NOLINT(readability-redundant-member-init)
};

/// The node's; what it points to must outlive it.
canopen::ServoConfig config_of(const BusSetup& setup, std::span<float> recorder,
                               std::string_view eds);

canopen::LoopTiming timing_of(const LoopFigures& figures);

}  // namespace smaservo::daemon
