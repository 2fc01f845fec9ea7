#pragma once
// Digital lines of a board, found by their names through libgpiod 2.

#include <memory>
#include <string>
#include <vector>

#include "hal/linux/system/files.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::hal {

struct LineSettings {
  std::string name;  ///< name as in `gpioinfo`; empty: the board has no such line
  bool active_low = false;
};

struct LinesSettings {
  LineSettings enable;  ///< output: the second switch
  LineSettings kick;    ///< output: a pulse to the one-shot for each kick
  /// Input: active means pressed. A normally closed switch has a pull-up and active_low = false.
  LineSettings emergency_stop;
  LineSettings driver_fault;  ///< input: active means fault
};

class Lines {
 public:
  Lines() = default;
  virtual ~Lines() = default;
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  // Each makes one system call, kick() two. If the board has no such line, an input is false and an
  // output does nothing.
  virtual bool emergency_stop() = 0;  ///< also true if the line cannot be read
  virtual bool driver_fault() = 0;    ///< also true if the line cannot be read
  virtual bool enable(bool on) = 0;   ///< false: the line was not set
  virtual bool kick() = 0;            ///< false: the line was not set
  virtual std::vector<OffAction> off_actions() = 0;
};

/// Whether a chip, such as "gpiochip0", below these roots can be opened and has a line of this
/// name.
bool has_line(const LinuxRoots& roots, const std::string& chip, const std::string& name);

/// Opens the lines and makes the outputs inactive. Throws DeviceError.
std::unique_ptr<Lines> open_lines(const LinuxRoots& roots, const LinesSettings& settings);

}  // namespace smaservo::hal
