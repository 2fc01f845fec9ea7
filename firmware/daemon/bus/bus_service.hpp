#pragma once
// The CANopen node of a daemon, in a thread of its own.

#include <memory>
#include <string>
#include <vector>

#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/daemon/bus/bus_pump.hpp"
#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/daemon/loop/desk.hpp"

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

/// Takes the device's settings from the desk and gives changed ones back to it; as long as it lives
/// nobody else changes them, and settings files that were read anew go through here. A reset of the
/// node ends the loop, with LoopLinks::restart; from then on the bus is silent. LSS cannot change
/// the bit rate, which is the interface's.
class BusService {
 public:
  /// Throws CanError.
  BusService(const BusSetup& setup, ParameterDesk& desk, LoopLinks& links,
             const LoopFigures& figures);
  ~BusService();
  BusService(const BusService&) = delete;
  BusService& operator=(const BusService&) = delete;

  CommandSource& command_source();
  /// Starts the thread, which runs until the service is destroyed.
  void start();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace smaservo::daemon
