#pragma once
// The distance of a loop from oscillation, from its frequency response.
// Source: Astrom and Hagglund, 'Advanced PID Control', 2006, chapter 4.6.

#include <complex>
#include <functional>
#include <numbers>

namespace smaservo::tune {

/// L(jω) of a loop that is stable when it is open, except for integrators; ω in rad/s.
using OpenLoop = std::function<std::complex<double>(double rad_s)>;

struct Margins {
  bool stable;         ///< the closed loop is stable: L does not encircle -1
  double gain;         ///< gain margin: factor on L at which it begins to oscillate; infinite: none
  double phase_rad;    ///< phase margin: tolerable lag at |L| = 1; infinite if |L| is never 1
  double sensitivity;  ///< M_s, the maximum of 1/|1 + L|
  double crossover_rad_s;    ///< highest frequency where |L| = 1; 0: none
  double oscillation_rad_s;  ///< frequency of the gain margin; 0: there is none
};

/// Searches the frequencies between these two. At `low` L must be flat or that of an integrator;
/// `high` must be beyond all crossings, and at most the Nyquist frequency of a sampled loop. Cost:
/// 60 values of L per decade and about 40 for each crossing.
Margins margins(const OpenLoop& loop, double low_rad_s, double high_rad_s);

/// The margins that every loop must have with every uncertain wire and in each of its states.
struct AskedMargins {
  double gain = 2;  ///< 6 dB
  double phase_rad = 0.25 * std::numbers::pi;
  double sensitivity = 2;

  bool kept(const Margins& m) const {
    return m.stable && m.gain >= gain && m.phase_rad >= phase_rad && m.sensitivity <= sensitivity;
  }
};

/// The worse of both, number by number; frequencies are those of the smaller margin.
Margins worse(const Margins& a, const Margins& b);

}  // namespace smaservo::tune
