#pragma once

#include <array>
#include <atomic>
#include <string>
#include <thread>

#include "hal/linux/system/files.hpp"

namespace smaservo::hal {

/// A file of the kernel with one number: SI is (number + offset) * scale.
struct SlowSensor {
  std::string path;  ///< under the root of sysfs; empty: the board has none
  double scale = 1;
  double offset = 0;
};

/// Supply and temperatures, some times a second by a thread of its own: such a reading may sleep
/// for milliseconds. One that fails is NaN until it comes back.
class SlowSensors {
 public:
  enum Which : unsigned char { supply, ambient, driver };
  static constexpr std::size_t count = 3;

  /// Each is read once. Throws DeviceError.
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
