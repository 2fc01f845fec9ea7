#pragma once

#include <array>
#include <atomic>
#include <string>
#include <thread>

#include "hal/linux/system/files.hpp"

namespace smaservo::hal {

/// A sensor whose reading is one number in a file of the kernel: SI is (number + offset) * scale.
struct SlowSensor {
  std::string path;  ///< file below the root of sysfs; empty: the board has no such sensor
  double scale = 1;
  double offset = 0;
};

/// Reads supply and temperatures several times a second in a thread of its own, because a read may
/// sleep for milliseconds. The value of a sensor that fails is NaN until it works again.
class SlowSensors {
 public:
  enum Which : unsigned char { supply, ambient, driver };
  static constexpr std::size_t count = 3;

  /// Reads each sensor once. Throws DeviceError.
  SlowSensors(const LinuxRoots& roots, const std::array<SlowSensor, count>& sensors);

  /// The last reading; no system call.
  double value(Which which) const { return values_.at(which).load(std::memory_order_relaxed); }

 private:
  void read_all(bool first);

  std::array<SlowSensor, count> sensors_;
  std::array<std::atomic<double>, count> values_;
  std::jthread thread_;
};

}  // namespace smaservo::hal
