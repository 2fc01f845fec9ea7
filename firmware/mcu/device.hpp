#pragma once
// The device's step in a file of its own: device.cpp is compiled with inlined small functions, all
// other files of the firmware only for size.

#include "firmware/device/device.hpp"

namespace smaservo::mcu {

Output<float> step_device(const Prepared<float>& prepared, Device<float>::State& state,
                          const Inputs<float>& in, const Command<float>& command, float dt_s);

/// The first half of the step, as Device::observe().
Measurement<float> observe_device(const Prepared<float>& prepared, Device<float>::State& state,
                                  const Inputs<float>& in, float dt_s);

}  // namespace smaservo::mcu
