#pragma once
// The device's step as a function of its own: device.cpp is compiled for speed, everything else of
// a firmware for size.

#include "firmware/device.hpp"

namespace smaservo {

Output<float> step_device(const Prepared<float>& prepared, Device<float>::State& state,
                          const Inputs<float>& in, const Command<float>& command, float dt_s);

}  // namespace smaservo
