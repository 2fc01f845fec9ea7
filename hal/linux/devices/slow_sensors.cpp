#include "hal/linux/devices/slow_sensors.hpp"

#include <algorithm>
#include <condition_variable>
#include <limits>
#include <mutex>

namespace smaservo::hal {

SlowSensors::SlowSensors(const LinuxRoots& roots, const std::array<SlowSensor, count>& sensors)
    : sensors_(sensors) {
  for (SlowSensor& sensor : sensors_) {
    sensor.path = sensor.path.empty() ? "" : roots.sys + "/" + sensor.path;
  }
  read_all(true);
  if (std::ranges::all_of(sensors_, [](const SlowSensor& s) { return s.path.empty(); })) {
    return;
  }
  thread_ = std::jthread([this](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any woken;
    std::unique_lock lock(mutex);
    while (!woken.wait_for(lock, stop, std::chrono::milliseconds(100), [] { return false; }) &&
           !stop.stop_requested()) {
      read_all(false);
    }
  });
}

void SlowSensors::read_all(bool first) {
  for (std::size_t i = 0; i < count; ++i) {
    double value = std::numeric_limits<double>::quiet_NaN();
    try {
      if (!sensors_.at(i).path.empty()) {
        value = (read_number(sensors_.at(i).path) + sensors_.at(i).offset) * sensors_.at(i).scale;
      }
    } catch (const DeviceError&) {
      if (first) {
        throw;
      }
    }
    values_.at(i).store(value, std::memory_order_relaxed);
  }
}

}  // namespace smaservo::hal
