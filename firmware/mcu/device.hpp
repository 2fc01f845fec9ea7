#pragma once
// The device's step as a function of its own: device.cpp is compiled with small functions in line,
// everything else of a firmware for size alone.

#include "firmware/device/device.hpp"

namespace smaservo::mcu {

Output<float> step_device(const Prepared<float>& prepared, Device<float>::State& state,
                          const Inputs<float>& in, const Command<float>& command, float dt_s);

/// Its first half by itself, as Device::observe().
Measurement<float> observe_device(const Prepared<float>& prepared, Device<float>::State& state,
                                  const Inputs<float>& in, float dt_s);

}  // namespace smaservo::mcu
