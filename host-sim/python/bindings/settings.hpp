#pragma once

#include "firmware/settings.hpp"
#include "host-sim/python/bindings/wire.hpp"

namespace smaservo::python {

/// smaservo.Settings: a type of its own, since Servo<double> checks nothing.
struct DeviceSettings {
  Settings<double> settings;
};

/// Throws ConfigError for settings that contradict each other.
void check_settings(const DeviceSettings& settings);

}  // namespace smaservo::python
