#pragma once
// One of the device's loops, linearised at an operating point: sampled, with the delay of a board
// and the PID of the firmware.

#include <complex>

#include "firmware/settings.hpp"
#include "host-sim/tune/linear/margins.hpp"

namespace smaservo::tune {

/// The loop from power to a controlled variable y and back. G(s) = y'/(C s + λ), held for a period.
struct LinearLoop {
  double period_s;
  int delay_ticks;  ///< delay from a sample to the current that responds to it, in addition to the
                    ///< hold
  double capacity_J_K, loss_W_K;
  double by_kelvin;  ///< y', positive if the variable moves in the direction that the loop expects
  double lag_s;      ///< low-pass of y, as in the observer's filter of a load; 0: none
  /// Slope of the compensated loss over the estimated temperature.
  double fed_forward_W_K;
  double law_W;  ///< slope of the heat law's power over y
  LoopGains<double> gains;
};

/// L(jω) = e^(-jωTd) G_h(jω) (y' H (law + PID) - λ^), G_h: the held G, per kelvin.
std::complex<double> open_loop(const LinearLoop& loop, double rad_s);

/// The margins of open_loop(), searched from far below the loop's frequency to Nyquist.
Margins margins(const LinearLoop& loop);

}  // namespace smaservo::tune
