#pragma once
// Digital lines of a board by their names, through libgpiod 2.

#include <memory>
#include <string>
#include <vector>

#include "hal/linux/system/files.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::hal {

struct LineSettings {
  std::string name;  ///< as `gpioinfo` shows it; empty: the board has none
  bool active_low = false;
};

struct LinesSettings {
  LineSettings enable;          ///< out: the second switch
  LineSettings kick;            ///< out: a pulse for each kick, to the one-shot
  LineSettings emergency_stop;  ///< in: active means pressed; normally closed is active_low = false
                                ///< with a pull-up
  LineSettings driver_fault;    ///< in: active means fault
};

class Lines {
 public:
  Lines() = default;
  virtual ~Lines() = default;
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  // One system call each, two for a kick. Without such a line: false, or nothing to do.
  virtual bool emergency_stop() = 0;  ///< a line that can not be read is pressed
  virtual bool driver_fault() = 0;    ///< likewise a fault
  virtual bool enable(bool on) = 0;   ///< false: the line was not set
  virtual bool kick() = 0;            ///< likewise
  virtual std::vector<OffAction> off_actions() = 0;
};

/// Throws DeviceError. Outputs begin inactive.
std::unique_ptr<Lines> open_lines(const LinuxRoots& roots, const LinesSettings& settings);

}  // namespace smaservo::hal
