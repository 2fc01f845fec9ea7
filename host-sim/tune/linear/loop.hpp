#pragma once
// One of the device's loops as it is near an operating point: sampled, with the ticks that a board
// takes, and the firmware's PID.

#include <complex>

#include "firmware/settings.hpp"
#include "host-sim/tune/linear/margins.hpp"

namespace smaservo::tune {

/// From power to a controlled variable y and back. G(s) = y'/(C s + λ), held for a period.
struct LinearLoop {
  double period_s;
  int delay_ticks;  ///< from a sample to the current that answers it, beside the hold
  double capacity_J_K, loss_W_K;
  double by_kelvin;        ///< y' in the direction that the loop takes for the right one
  double lag_s;            ///< low-pass of y as the observer filters a load; 0: none
  double fed_forward_W_K;  ///< loss that the device adds, by the estimated temperature
  double law_W;            ///< the heat law's power by y
  LoopGains<double> gains;
};

/// L(jω) = e^(-jωTd) G_h(jω) (y' H (law + PID) - λ^), G_h: the held G by kelvin.
std::complex<double> open_loop(const LinearLoop& loop, double rad_s);

/// At frequencies from far below the loop's to Nyquist.
Margins margins(const LinearLoop& loop);

}  // namespace smaservo::tune
