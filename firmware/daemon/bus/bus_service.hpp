#pragma once
// The CANopen node of a daemon, in a thread of its own.

#include <memory>
#include <string>

#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/daemon/bus/bus_pump.hpp"
#include "firmware/daemon/loop/desk.hpp"

namespace smaservo::daemon {

struct BusSetup {
  std::string interface;  ///< "can0", or "udp", "udp:GROUP", "udp:GROUP:PORT"
  double command_source_timeout_s = 0;
  std::string folder;  ///< of the store; empty: nothing can be stored
  canopen::Ceilings ceilings;
  canopen::AccessKeys keys;
  std::string board;  ///< as 1009h calls it
  int priority = 0;   ///< of the thread's SCHED_FIFO; 0: none
};

/// Takes the device's settings from the desk and gives changed ones back to it. A reset of the node
/// ends the loop, with LoopLinks::restart; from then on the bus is silent. The bit rate is the
/// interface's own: LSS may not choose another one.
class BusService {
 public:
  /// Throws CanError.
  BusService(const BusSetup& setup, ParameterDesk& desk, LoopLinks& links,
             const LoopFigures& figures);
  ~BusService();
  BusService(const BusService&) = delete;
  BusService& operator=(const BusService&) = delete;

  CommandSource& command_source();
  /// From now on, until it is destroyed.
  void start();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace smaservo::daemon
