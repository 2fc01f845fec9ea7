#include "host-sim/identify/runs/offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "host-sim/checks/statistics.hpp"

namespace smaservo::identify {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// The temperatures of a transformation on heating and on cooling; NaN: not seen.
struct Transitions {
  double heating_K = unknown, cooling_K = unknown;

  double middle_K() const { return 0.5 * (heating_K + cooling_K); }
};

/// Where the strain passes the middle of its range: it falls on heating and rises on cooling.
Transitions of_strain(const Run& run) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double strain : run.strain) {
    low = strain < low ? strain : low;  // both comparisons are false for NaN
    high = high < strain ? strain : high;
  }
  const double half = 0.5 * (low + high);
  std::vector<double> falling_K, rising_K;
  std::optional<std::size_t> before;
  for (std::size_t i = 0; i < run.strain.size(); ++i) {
    if (std::isnan(run.strain[i])) {
      continue;
    }
    if (before && (run.strain[*before] < half) != (run.strain[i] < half)) {
      (run.strain[i] < half ? falling_K : rising_K)
          .push_back(0.5 * (run.temperature_K[*before] + run.temperature_K[i]));
    }
    before = i;
  }
  return {checks::median(falling_K), checks::median(rising_K)};
}

/// The peaks of the heat flow: the highest while the sample is heated, the lowest while it cools.
Transitions of_heat_flow(const Run& run) {
  Transitions found;
  double highest = -std::numeric_limits<double>::infinity();
  double lowest = -highest;
  for (std::size_t i = 1; i < run.power_W_kg.size(); ++i) {
    const double flow_W_kg = run.power_W_kg[i];
    const bool heated = run.temperature_K[i] > run.temperature_K[i - 1];
    if (heated && flow_W_kg > highest) {
      highest = flow_W_kg;
      found.heating_K = run.temperature_K[i];
    } else if (run.temperature_K[i] < run.temperature_K[i - 1] && flow_W_kg < lowest) {
      lowest = flow_W_kg;
      found.cooling_K = run.temperature_K[i];
    }
  }
  return found;
}

/// Where a curve is steepest.
double turning_K(const Surface<double>& surface, double stress_Pa) {
  const auto at = [&](const double(&c)[3]) { return c[0] + stress_Pa * (c[1] + stress_Pa * c[2]); };
  const double start_K = at(surface.start_K);
  const double z = surface.turning[0] + surface.turning[1] * stress_Pa;
  return start_K + z * (at(surface.finish_K) - start_K);
}

/// By how much a run's transitions lie above the wire's.
double offset_K(const Wire<double>& wire, const Run& run) {
  const bool heat = run.kind == RunKind::calorimetry;
  if (!heat && (run.kind != RunKind::bath || run.strain.empty())) {
    return unknown;
  }
  const Transitions seen = heat ? of_heat_flow(run) : of_strain(run);
  const double stress_Pa = checks::median(run.stress_Pa);
  const double own_K = 0.5 * (turning_K(wire.kinetics.m2a, stress_Pa) +
                              turning_K(first_surface(wire.kinetics.a2m_a2r), stress_Pa));
  return seen.middle_K() - own_K;
}

}  // namespace

double transitions_offset_K(const Wire<double>& wire, const std::vector<Run>& runs) {
  std::vector<double> offsets_K;
  for (const Run& run : runs) {
    if (const double of_run_K = offset_K(wire, run); !std::isnan(of_run_K)) {
      offsets_K.push_back(of_run_K);
    }
  }
  const double offset_K = checks::median(offsets_K);
  return std::abs(offset_K) > within_reach_K ? offset_K : 0;
}

Wire<double> moved(Wire<double> wire, double by_K) {
  ThreePhaseParams<double>& k = wire.kinetics;
  Surface<double> a2m = first_surface(k.a2m_a2r);
  Surface<double> a2r = second_surface(k.a2m_a2r);
  for (Surface<double>* surface : {&k.m2a, &a2m, &a2r, &k.r2a, &k.r2m}) {
    surface->start_K[0] += by_K;
    surface->finish_K[0] += by_K;
  }
  k.a2m_a2r = pair_surfaces(a2m, a2r);
  return wire;
}

}  // namespace smaservo::identify
