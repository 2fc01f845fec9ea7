#pragma once
// The CANopen node of a daemon, in a thread of its own.

#include <memory>

#include "firmware/daemon/bus/bus_setup.hpp"
#include "firmware/daemon/loop/command_source.hpp"
#include "firmware/daemon/loop/desk.hpp"

namespace smaservo::daemon {

/// Takes the device's settings from the desk and gives changed ones back to it; during its life no
/// other thread changes them, and settings files that are read anew go through this service. A
/// reset of the node ends the loop with LoopLinks::restart; from then on the bus is silent. LSS
/// cannot change the bit rate, which belongs to the interface.
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
