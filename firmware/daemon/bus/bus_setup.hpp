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
  bool unattended = false;  ///< heat may continue without a command source
  std::string board;        ///< name of the board, in 1009h
  int priority = 0;         ///< priority of the thread in SCHED_FIFO; 0: none
  /// Values that the store may have lost, for the change log.
  // g++ warns of members that designated initializers leave out, unless they have their own
  // initializer.
  std::vector<LostValue> lost = {};  // NOLINT(readability-redundant-member-init)
};

/// The node's configuration; the objects that it refers to must outlive it.
canopen::ServoConfig config_of(const BusSetup& setup, std::span<float> recorder,
                               std::string_view eds);

canopen::LoopTiming timing_of(const LoopFigures& figures);

}  // namespace smaservo::daemon
