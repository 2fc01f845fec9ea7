#include "host-sim/identify/runs/run_checks.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <span>

#include "host-sim/identify/runs/run_statistics.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::identify {
namespace {

constexpr std::size_t min_rows = 20;
constexpr double min_strain = 0.003;
constexpr double min_resistance_change = 0.02;
constexpr double min_temperature_span_K = 10;
constexpr double max_run_strain = 0.2;
constexpr double max_stress_Pa = 1.5e9;
constexpr double max_heating_K_s = 1e5;
constexpr double min_resistivity_ohm_m = 0.5e-6 / 5, max_resistivity_ohm_m = 1.5e-6 * 5;
constexpr double coldest_K = 150, hottest_K = 500;  ///< no NiTi wire transforms beyond

void check_content(const Run& run) {
  if (run.stress_Pa.size() < min_rows) {
    fail(run, fmt::format("has {} rows, at least {} are needed; record a full heating and cooling",
                          run.stress_Pa.size(), min_rows));
  }
  if (run.kind == RunKind::calorimetry) {
    const Range temperature_K = range_of(run.temperature_K);
    if (temperature_K.high - temperature_K.low < min_temperature_span_K) {
      fail(run, fmt::format("the temperature spans {:.1f} K; heat and cool the sample through both "
                            "transformations",
                            temperature_K.high - temperature_K.low));
    }
    return;
  }
  if (run.strain.empty() && (run.kind != RunKind::bath || run.resistance_ohm.empty())) {
    fail(run, fmt::format("has nothing to fit a {} run to; record strain_ref or displacement_mm{}",
                          name_of(run.kind),
                          run.kind == RunKind::bath
                              ? ", or resistance_ohm, or (of a calorimeter) power_W_per_g"
                              : ""));
  }
  const Range strain = range_of(run.strain);
  const Range ohm = range_of(run.resistance_ohm);
  const double change = ohm.middle > 0 ? (ohm.high - ohm.low) / ohm.middle : 0;
  if (strain.high - strain.low < min_strain && change < min_resistance_change) {
    fail(run,
         fmt::format("the wire does not move: strain spans {:.2f} %, resistance {:.1f} %; heat "
                     "and cool it through both transformations",
                     100 * (strain.high - strain.low), 100 * change));
  }
}

void check_units(const Run& run, const Geometry<double>& geometry) {
  if (const double span = span_of(run.strain); span > max_run_strain) {
    fail(run, fmt::format("strain spans {:.3g}, no wire survives more than {}; a strain in per "
                          "cent is strain_ref_percent; for a displacement, check its unit and the "
                          "length of the wire ({:.4g} mm)",
                          span, max_run_strain, 1e3 * geometry.length_m));
  }
  const double stress_Pa = *std::ranges::max_element(run.stress_Pa);
  if (stress_Pa > max_stress_Pa) {
    fail(run, fmt::format("the stress reaches {:.4g} MPa, above {} MPa a wire breaks; check the "
                          "load's unit and the diameter (of {:.4g} um)",
                          1e-6 * stress_Pa, 1e-6 * max_stress_Pa, 1e6 * geometry.diameter_m));
  }
  const bool by_temperature = run.kind == RunKind::bath || run.kind == RunKind::calorimetry;
  if (by_temperature) {
    const auto [coldest, hottest] = std::ranges::minmax(run.temperature_K);
    if (hottest < coldest_K || coldest > hottest_K) {
      fail(run, fmt::format("temperatures are {:.4g} to {:.4g} K ({:.4g} to {:.4g} degC); {}",
                            coldest, hottest, coldest - zero_degC_K, hottest - zero_degC_K,
                            hottest < coldest_K ? "are they degC in a column of K?"
                                                : "are they K in a column of degC?"));
    }
  }
  const double ohm = range_of(run.resistance_ohm).middle;
  const double resistivity = ohm * geometry.area_m2() / geometry.length_m;
  if (!known(run.resistance_ohm).empty() &&
      !(resistivity > min_resistivity_ohm_m && resistivity < max_resistivity_ohm_m)) {
    fail(run,
         fmt::format("a resistance of {:.4g} ohm means {:.3g} uohm_m for {:.4g} mm of {:.4g} um "
                     "wire, NiTi has 0.5 to 1.5; check length, diameter and the units of "
                     "current and voltage",
                     ohm, 1e6 * resistivity, 1e3 * geometry.length_m, 1e6 * geometry.diameter_m));
  }
  const double heat_J_K =
      density_kg_m3 * specific_heat_J_kgK * geometry.area_m2() * geometry.length_m;
  for (std::size_t i = 0; i < std::min(run.current_A.size(), run.voltage_V.size()); ++i) {
    const double power_W = run.current_A[i] * run.voltage_V[i];
    if (power_W > max_heating_K_s * heat_J_K) {
      fail(run, fmt::format("row {}: {:.4g} A at {:.4g} V would heat the wire by {:.2g} K/s; check "
                            "the units, length and diameter",
                            i + 1, run.current_A[i], run.voltage_V[i], power_W / heat_J_K));
    }
  }
}

/// The longest stretch of rows at an extreme value, and the number of rows in stretches of at least
/// five.
struct Stretch {
  double value = 0;
  std::size_t first = 0, count = 0, all = 0;
};
Stretch held(const Values& values, double extreme) {
  Stretch longest{extreme};
  for (std::size_t i = 0; i < values.size();) {
    std::size_t stop = i;
    while (stop < values.size() && values[stop] == extreme) {
      ++stop;
    }
    const std::size_t count = stop - i;
    longest.all += count >= 5 ? count : 0;
    if (count > longest.count) {
      longest.first = i;
      longest.count = count;
    }
    i = stop + 1;
  }
  return longest;
}

bool is_long(const Stretch& stretch, std::size_t rows) {
  return stretch.count >= 5 && 10 * stretch.all > rows;
}

/// The values of another column in the rows of a stretch, without its first and last rows.
std::span<const double> beside(const Values& values, const Stretch& stretch) {
  const std::size_t edge = std::max<std::size_t>(1, stretch.count / 10);
  return std::span(values).subspan(stretch.first + edge, stretch.count - 2 * edge);
}

/// The span of the means of its three thirds, so that noise does not count as a change.
double change(std::span<const double> values) {
  Values means;
  for (std::size_t third = 0; third < 3; ++third) {
    const std::size_t from = third * values.size() / 3, to = (third + 1) * values.size() / 3;
    const Values some = known({values.begin() + static_cast<std::ptrdiff_t>(from),
                               values.begin() + static_cast<std::ptrdiff_t>(to)});
    if (!some.empty()) {
      means.push_back(std::accumulate(some.begin(), some.end(), 0.0) /
                      static_cast<double>(some.size()));
    }
  }
  return span_of(means);
}

/// The finest step of the column, due to its converter or to the digits in which it was written.
double step_of(const Values& values) {
  Values sorted = known(values);
  std::ranges::sort(sorted);
  double step = std::numeric_limits<double>::infinity();
  const double min = 1e-9 * (sorted.back() - sorted.front());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] - sorted[i - 1] > min) {
      step = std::min(step, sorted[i] - sorted[i - 1]);
    }
  }
  return step;
}

/// Whether the column ends abruptly at the stretch. A quantity that comes to rest slows down first,
/// and accelerates when it leaves: the rows next to the stretch differ by no more than one step of
/// the converter, or by amounts that differ much from row to row. A clipped column arrives and
/// leaves with a steady slope.
bool breaks_off(const Values& values, const Stretch& stretch) {
  const double min = 1.5 * step_of(values);
  const auto steady = [&](double first, double second, double third) {
    return std::abs(second - first) > min &&
           std::abs(third - second) < 1.25 * std::abs(second - first);
  };
  const std::size_t at = stretch.first;
  const std::size_t after = stretch.first + stretch.count;
  const bool comes = at >= 3;
  const bool goes = after + 3 <= values.size();
  return (comes || goes) && (!comes || steady(values[at - 1], values[at - 2], values[at - 3])) &&
         (!goes || steady(values[after], values[after + 1], values[after + 2]));
}

/// Whether the noise is several fine steps in all rows outside the stretch.
bool is_noisy_elsewhere(const Values& values, const Stretch& stretch) {
  std::size_t equal = 0, pairs = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] != stretch.value) {
      ++pairs;
      equal += values[i] == values[i - 1] ? 1U : 0U;
    }
  }
  return stretch.count >= min_rows && 10 * equal < pairs &&
         span_of(values) > 1000 * step_of(values);
}

/// A source may hold current or voltage exactly, which is no clipping. The resistance of a wire
/// stays within 40 %, so the other quantity then changes by no more than that.
void check_converters(const Run& run) {
  const auto check = [&](const Values& held_values, const Values& others, const char* name) {
    if (held_values.empty() || others.empty()) {
      return;
    }
    const Stretch stretch = held(held_values, *std::ranges::max_element(held_values));
    if (!is_long(stretch, held_values.size()) || !(stretch.value > 0)) {
      return;
    }
    const auto [min, max] = std::ranges::minmax(beside(others, stretch));
    if (max > 1.4 * std::max(min, 0.0)) {
      fail(run, fmt::format("{} stands still at {:.6g} for {} rows while the other changes by "
                            "more than a wire's resistance can; its converter is clipped, widen "
                            "its range",
                            name, stretch.value, stretch.count));
    }
  };
  check(run.voltage_V, run.current_A, "voltage");
  check(run.current_A, run.voltage_V, "current");
}

/// A column of strain, temperature or resistance is clipped if (1) more than a tenth of its rows
/// hold its least or greatest value, in stretches of at least five; (2) another quantity changes by
/// more than 5 % of its span during the longest stretch; and (3) the column arrives at this stretch
/// and leaves it with a steady slope, or is noisy in all other rows. A wire at rest, a column of
/// coarse steps and a thermostat's hold fulfil some of these conditions, not all.
void check_clipped(const Run& run) {
  struct Named {
    const char* name;
    const Values& values;
  };
  const bool by_temperature = run.kind == RunKind::bath || run.kind == RunKind::calorimetry;
  const Values nothing;
  const Named columns[] = {{"strain", run.strain},
                           {"temperature", by_temperature ? run.temperature_K : nothing},
                           {"resistance", run.resistance_ohm},
                           {"current", run.current_A},
                           {"voltage", run.voltage_V}};
  constexpr std::size_t judged = 3;
  for (std::size_t c = 0; c < judged; ++c) {
    const Values& values = columns[c].values;
    const double span = span_of(values);
    if (!(span > 0)) {
      continue;
    }
    const Values some = known(values);
    const auto [min, max] = std::ranges::minmax(some);
    for (const double extreme : {min, max}) {
      const Stretch stretch = held(values, extreme);
      if (!is_long(stretch, values.size())) {
        continue;
      }
      const bool others_change = std::ranges::any_of(columns, [&](const Named& other) {
        return &other.values != &values && !other.values.empty() &&
               change(beside(other.values, stretch)) > 0.05 * span_of(other.values);
      });
      if (others_change && (breaks_off(values, stretch) || is_noisy_elsewhere(values, stretch))) {
        fail(run, fmt::format("{} stands still at {:.6g} for {} rows while the wire moves; its "
                              "converter is clipped or its sensor at a stop, widen its range",
                              columns[c].name, extreme, stretch.count));
      }
    }
  }
  check_converters(run);
}

}  // namespace

void fail(const Run& run, const std::string& what) {
  throw files::UserError(fmt::format("{}: {}", run.name, what));
}

void check_run(const Run& run, const Geometry<double>& geometry) {
  check_content(run);
  check_signs(run, geometry);
  check_units(run, geometry);
  check_clipped(run);
}

}  // namespace smaservo::identify
