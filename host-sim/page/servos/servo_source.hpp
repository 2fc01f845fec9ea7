#pragma once
// The bridge to the servos of one bus, with its thread.

#include <optional>

#include "host-sim/page/source.hpp"

namespace smaservo::page {

struct ServoOptions {
  std::string can;                   ///< name of the bus as for open_can()
  std::optional<std::uint32_t> key;  ///< key of an access level of the servos (2003h:2)
  double sync_s = 0;                 ///< period of SYNC; 0: live values are polled
  /// Signals sent by SYNC; at most eight, two in each PDO.
  std::vector<std::string> sync_signals{"strain",          "wire_temperature_K", "resistance_ohm",
                                        "drive_current_A", "setpoint",           "power_W"};
  float watch_s = 1;       ///< longest silence of the bridge before a servo ends its heat
  double timeout_s = 0.5;  ///< longest wait for a servo's answer
  bool read_only = false;  ///< applies to all clients
};

/// Opens the bus. Throws UserError.
std::unique_ptr<Source> make_servo_source(const ServoOptions& options);

}  // namespace smaservo::page
