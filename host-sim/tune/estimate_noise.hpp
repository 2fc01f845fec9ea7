#pragma once

#include "host-sim/tune/proposal.hpp"

namespace smaservo::tune {

/// Standard deviation of the estimated strain due to the noise of current and voltage, half way
/// along the heating branch: the difference of two observers on one simulated wire for 2 s, one of
/// them with clean sensors.
double estimate_noise(const TunedPlant& plant, const Proposal& p);

}  // namespace smaservo::tune
