#include "hal/sim/pair.hpp"

#include <algorithm>
#include <cmath>

namespace smaservo::hal {
namespace {

constexpr double close_m = 1e-9;
constexpr int max_steps = 60;

}  // namespace

SimPair::SimPair(SimBoard& first, const Geometry<double>& first_wire, SimBoard& second,
                 const Geometry<double>& second_wire)
    : first_(first),
      second_(second),
      first_wire_(first_wire),
      second_wire_(second_wire),
      space_m_(first.truth().strain * first_wire.length_m +
               second.truth().strain * second_wire.length_m),
      force_N_(second.truth().stress_Pa * second_wire.area_m2()) {}

double SimPair::excess_m(double force_N) const {
  const double first_Pa = force_N / first_wire_.area_m2() + first_.surroundings.added_stress_Pa;
  return first_.strain_after(std::max(first_Pa, 0.0)) * first_wire_.length_m +
         second_.strain_after(force_N / second_wire_.area_m2()) * second_wire_.length_m - space_m_;
}

/// The force at which the lengths of both wires fit. More force makes both wires longer, so there
/// is one root; it is found by the Illinois method between two bounds.
double SimPair::balanced_N() const {
  double step_N = 1e6 * second_wire_.area_m2();
  double low_N = force_N_;
  double low_m = excess_m(low_N);
  double high_N = low_N;
  double high_m = low_m;
  for (; low_m > 0 && low_N > 0; step_N *= 4) {
    high_N = low_N;
    high_m = low_m;
    low_N = std::max(low_N - step_N, 0.0);
    low_m = excess_m(low_N);
  }
  if (low_m > 0) {
    return 0;  // both wires are slack
  }
  for (; high_m < 0; step_N *= 4) {
    low_N = high_N;
    low_m = high_m;
    high_N += step_N;
    high_m = excess_m(high_N);
  }
  for (int i = 0, side = 0; i < max_steps && high_m - low_m > close_m; ++i) {
    const double at_N = (low_N * high_m - high_N * low_m) / (high_m - low_m);
    const double at_m = excess_m(at_N);
    if (std::abs(at_m) < close_m) {
      return at_N;
    }
    if (at_m < 0) {
      low_N = at_N;
      low_m = at_m;
      high_m *= side < 0 ? 0.5 : 1;
      side = -1;
    } else {
      high_N = at_N;
      high_m = at_m;
      low_m *= side > 0 ? 0.5 : 1;
      side = 1;
    }
  }
  return 0.5 * (low_N + high_N);
}

std::array<ReadStatus, 2> SimPair::read(Frame& first, Frame& second) {
  for (int i = 0; i < first_.parts(); ++i) {
    first_.begin_part();
    second_.begin_part();
    const bool carry =
        first_.faults().circuit != Circuit::broken && second_.faults().circuit != Circuit::broken;
    force_N_ = carry ? balanced_N() : 0;
    const double first_Pa = force_N_ / first_wire_.area_m2() + first_.surroundings.added_stress_Pa;
    first_.finish_part(carry ? std::max(first_Pa, 0.0) : 0);
    second_.finish_part(force_N_ / second_wire_.area_m2());
  }
  const ReadStatus one = first_.sample(first);
  return {one, second_.sample(second)};
}

}  // namespace smaservo::hal
