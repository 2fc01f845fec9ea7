#include "firmware/mcu/device.hpp"

namespace smaservo::mcu {

Output<float> step_device(const Prepared<float>& prepared, Device<float>::State& state,
                          const Inputs<float>& in, const Command<float>& command, float dt_s) {
  return Device<float>::step(prepared, state, in, command, dt_s);
}

Measurement<float> observe_device(const Prepared<float>& prepared, Device<float>::State& state,
                                  const Inputs<float>& in, float dt_s) {
  return Device<float>::observe(prepared, state, in, dt_s);
}

}  // namespace smaservo::mcu
