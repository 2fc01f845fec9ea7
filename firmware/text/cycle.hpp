#pragma once

#include "firmware/device/cycle.hpp"
#include "hal/sim/board.hpp"

namespace smaservo::text {

/// One step of the device and its time; in a simulation also the truth at the sample's time.
struct Cycle : DeviceStep<double> {
  double time_s;
  hal::SimTruth truth;
};

}  // namespace smaservo::text
