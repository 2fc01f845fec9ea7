#pragma once

#include "firmware/device/cycle.hpp"
#include "hal/sim/board.hpp"

namespace smaservo::text {

/// One step, when it was, and, of a simulation, what was true when the sample was taken.
struct Cycle : DeviceStep<double> {
  double time_s;
  hal::SimTruth truth;
};

}  // namespace smaservo::text
