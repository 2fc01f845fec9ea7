#include "hal/sim/pair.hpp"

#include <algorithm>

#include "hal/sim/balance.hpp"

namespace smaservo::hal {
namespace {

constexpr double close_m = 1e-9;

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

/// The force at which the lengths of both wires fit; 0 if both are slack.
double SimPair::balanced_N() const {
  return balance(force_N_, 0, 1e6 * second_wire_.area_m2(), close_m,
                 [&](double force_N) { return excess_m(force_N); });
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
