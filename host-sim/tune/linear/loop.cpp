#include "host-sim/tune/linear/loop.hpp"

#include <cmath>
#include <numbers>

namespace smaservo::tune {
namespace {

using Complex = std::complex<double>;

/// A low-pass as in the firmware: x += (u - x) dt/(dt + time).
Complex low_pass(double time_s, double dt_s, const Complex& back) {
  const double share = dt_s / (dt_s + time_s);
  return share / (1.0 - (1 - share) * back);
}

/// Pid::step from error to power, with a constant set-point.
Complex pid(const LoopGains<double>& q, double dt_s, const Complex& back) {
  const Complex integral = q.integral_1_s * dt_s / (1.0 - back);
  const Complex derivative =
      q.derivative_s / dt_s * (1.0 - back) * low_pass(q.derivative_filter_s, dt_s, back);
  return q.proportional * (1.0 + integral + derivative);
}

}  // namespace

Complex open_loop(const LinearLoop& loop, double rad_s) {
  const double dt_s = loop.period_s;
  const Complex back = std::polar(1.0, -rad_s * dt_s);  // z^-1
  // (1 - a)/λ z^-1/(1 - a z^-1) with a = exp(-λ T/C)
  const double exponent = loop.loss_W_K * dt_s / loop.capacity_J_K;
  const double a = std::exp(-exponent);
  const Complex held = -std::expm1(-exponent) / loop.loss_W_K * back / (1.0 - a * back) *
                       std::pow(back, loop.delay_ticks);
  const Complex seen = loop.lag_s > 0 ? low_pass(loop.lag_s, dt_s, back) : Complex(1);
  const Complex by_y = loop.law_W + pid(loop.gains, dt_s, back);
  return held * (loop.by_kelvin * seen * by_y - loop.fed_forward_W_K);
}

Margins margins(const LinearLoop& loop) {
  const double nyquist = std::numbers::pi / loop.period_s;
  return margins([&](double omega) { return open_loop(loop, omega); }, 1e-6 * nyquist, nyquist);
}

}  // namespace smaservo::tune
