#pragma once
// The pull at which what a wire pulls at holds it.

#include <algorithm>
#include <cmath>

namespace smaservo::hal {

/// The root of `excess`, which rises with its argument: what is too long at a pull. It is searched
/// for from `from` on in steps that grow from `step`, then between two bounds by the Illinois
/// method, up to an excess of `close` or 60 steps. `least` if the excess is positive there.
template <class Excess>
double balance(double from, double least, double step, double close, const Excess& excess) {
  constexpr int max_steps = 60;
  double low = from;
  double low_excess = excess(low);
  double high = low;
  double high_excess = low_excess;
  for (; low_excess > 0 && low > least; step *= 4) {
    high = low;
    high_excess = low_excess;
    low = std::max(low - step, least);
    low_excess = excess(low);
  }
  if (low_excess > 0) {
    return least;
  }
  for (; high_excess < 0; step *= 4) {
    low = high;
    low_excess = high_excess;
    high += step;
    high_excess = excess(high);
  }
  for (int i = 0, side = 0; i < max_steps && high_excess - low_excess > close; ++i) {
    const double at = (low * high_excess - high * low_excess) / (high_excess - low_excess);
    const double here = excess(at);
    if (std::abs(here) < close) {
      return at;
    }
    if (here < 0) {
      low = at;
      low_excess = here;
      high_excess *= side < 0 ? 0.5 : 1;
      side = -1;
    } else {
      high = at;
      high_excess = here;
      low_excess *= side > 0 ? 0.5 : 1;
      side = 1;
    }
  }
  return 0.5 * (low + high);
}

}  // namespace smaservo::hal
