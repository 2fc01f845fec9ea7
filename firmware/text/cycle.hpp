#pragma once

#include "firmware/device/cycle.hpp"
#include "hal/sim/board.hpp"

namespace smaservo {

/// One step, when it was, and, of a simulation, what was true when the sample was taken.
struct Cycle : DeviceStep<double> {
  double time_s;
  SimTruth truth;
};

}  // namespace smaservo
