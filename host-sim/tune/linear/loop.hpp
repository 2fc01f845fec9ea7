#pragma once
// One of the device's loops, linearised at an operating point: sampled, with the delay of a board
// and the firmware's PID.

#include <complex>

#include "firmware/settings.hpp"
#include "host-sim/tune/linear/margins.hpp"

namespace smaservo::tune {

/// The loop from power to a controlled variable y and back. G(s) = y'/(C s + λ), held for a period.
struct LinearLoop {
  double period_s;
  int delay_ticks;  ///< from a sample to the current that answers it, beside the hold
  double capacity_J_K, loss_W_K;
  double by_kelvin;        ///< y', positive where the variable moves the way that the loop expects
  double lag_s;            ///< low-pass of y as the observer filters a load; 0: none
  double fed_forward_W_K;  ///< slope of the loss that the device compensates, over the estimated
                           ///< temperature
  double law_W;            ///< slope of the heat law's power over y
  LoopGains<double> gains;
};

/// L(jω) = e^(-jωTd) G_h(jω) (y' H (law + PID) - λ^), G_h: the held G by kelvin.
std::complex<double> open_loop(const LinearLoop& loop, double rad_s);

/// The margins of open_loop(), searched from far below the loop's frequency to Nyquist.
Margins margins(const LinearLoop& loop);

}  // namespace smaservo::tune
