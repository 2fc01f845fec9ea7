#pragma once
// The conditions that settings must fulfil: each value by itself, and all of them together. A rule
// names both parameters that contradict each other; messages for users are made elsewhere.

#include <cmath>

#include "firmware/parameters/parameters.hpp"
#include "model/wire/plant.hpp"

namespace smaservo {

enum class Problem : std::uint8_t {
  none,
  not_finite,
  below,          ///< below its least value
  above,          ///< above its greatest value
  contradiction,  ///< two parameters contradict each other: a rule does not hold
};

/// The problem of settings. `parameter` and `other` are rows of `parameters`.
struct Finding {
  Problem problem = Problem::none;
  std::size_t parameter = no_parameter;
  std::size_t other = no_parameter;  ///< the other parameter of a contradiction
  std::size_t rule = 0;              ///< for a contradiction: row of `parameter_rules`

  /// Whether there is no problem.
  constexpr bool ok() const { return problem == Problem::none; }
};

enum class Relation : std::uint8_t {
  below,       ///< factor a + plus < b
  not_above,   ///< factor a + plus <= b
  heats,       ///< start a and finish b of a process on heating are within `surface_range`
  cools,       ///< start a and finish b of a process on cooling are within `surface_range`
  curvature,   ///< curvature a + b stress of a process is within `surface_range`
  turning,     ///< turning a + b stress of a process is within `surface_range`
  idle_power,  ///< the power of the current a in a cold wire <= b
  idle_heat,  ///< the same power <= max_idle_share of the power that holds the temperature b - plus
};

/// The minimum current flows regardless of the limits of temperature and duty, because the
/// resistance cannot be measured without it. So it must not heat the wire by more than this share
/// of what its temperature limit allows.
inline constexpr double max_idle_share = 0.1;

/// Parameters in a relation, as rows of `parameters`. The rule counts as fulfilled while one of its
/// parameters is not set or not used. Relations of a process are checked at stresses from 0 to
/// wire.limits.stress_Pa.
struct RuleRow {
  std::uint16_t a, b;
  std::uint16_t plus;  ///< no_parameter: none
  Relation relation;
  float factor;
};

/// A rule with its text.
struct Rule : RuleRow {
  std::string_view meaning;
};

namespace detail {

/// row_of() calls this function for an unknown path. That is a compile error, because it is not
/// constexpr; so it needs no definition.
std::size_t no_such_parameter();

/// The row of this path. A path that is not in the table does not compile.
consteval std::uint16_t row_of(std::string_view path) {
  return static_cast<std::uint16_t>(find_parameter(path) < parameter_count ? find_parameter(path)
                                                                           : no_such_parameter());
}

consteval Rule rule(std::string_view a, Relation relation, std::string_view b,
                    std::string_view meaning, float factor = 1, std::string_view plus = "") {
  constexpr auto none = static_cast<std::uint16_t>(no_parameter);
  return {{row_of(a), row_of(b), plus.empty() ? none : row_of(plus), relation, factor}, meaning};
}

inline constexpr std::string_view heats =
    "both must be between 150 and 600 K, finish at least 1 K above start, at any stress up to "
    "wire.limits.stress_Pa";
inline constexpr std::string_view cools =
    "both must be between 150 and 600 K, finish at least 1 K below start, at any stress up to "
    "wire.limits.stress_Pa";
inline constexpr std::string_view curves =
    "curvature must be between 0.001 and 30 at any stress up to wire.limits.stress_Pa";
inline constexpr std::string_view turns =
    "the turning point must be between 0.05 and 0.95 at any stress up to wire.limits.stress_Pa";

consteval auto all_rules() {
  using enum Relation;
  constexpr std::string_view is_first = "the limit must act before the trip";
  constexpr std::string_view timeout = "a time-out must be at least two periods long";
  constexpr std::string_view tracking = "the anti-windup must not be faster than the loop";
  constexpr std::string_view between = "the range between them must not be empty";
  constexpr std::string_view wire = "the maker of the wire allows no more";
  return std::to_array<Rule>({
      rule("timing.period_s", not_above, "timing.command_timeout_s", timeout, 2),
      rule("timing.period_s", not_above, "timing.sample_timeout_s", timeout, 2),
      rule("timing.period_s", not_above, "strain.tracking_s", tracking),
      rule("timing.period_s", not_above, "temperature.tracking_s", tracking),
      rule("timing.period_s", not_above, "resistance.tracking_s", tracking),
      rule("timing.period_s", not_above, "force.tracking_s", tracking),
      rule("limits.min_current_A", below, "limits.current_A", between),
      rule("limits.min_current_A", idle_power, "limits.power_W",
           "the minimum current alone must not exceed the power"),
      rule("limits.min_current_A", idle_heat, "limits.temperature_K",
           "the minimum current must take at most 10 % of the power that holds the wire at its "
           "limit, "
           "since it is never reduced",
           1, "limits.hot_spot_K"),
      rule("limits.current_A", below, "trips.current_A", is_first),
      rule("trips.current_A", below, "measurement.current_full_scale_A",
           "a current above the full scale could not be measured"),
      rule("trips.current_offset_A", below, "limits.min_current_A",
           "the minimum current must be above any offset that arming accepts"),
      rule("limits.temperature_K", below, "trips.temperature_K", is_first),
      rule("limits.temperature_K", not_above, "wire.limits.temperature_K", wire),
      rule("wire.m2a.start_0_K", below, "limits.temperature_K",
           "the wire could not start to contract below the limit", 1, "limits.hot_spot_K"),
      rule("trips.max_ambient_K", below, "limits.temperature_K",
           "the ambient temperature alone must not reach the limit"),
      rule("trips.min_ambient_K", below, "trips.max_ambient_K", between),
      rule("limits.min_strain", below, "limits.max_strain", between),
      rule("trips.min_strain", below, "limits.min_strain", is_first),
      rule("limits.max_strain", below, "trips.max_strain", is_first),
      rule("limits.min_strain", not_above, "axis.zero_strain", "position 0 must be allowed"),
      rule("axis.zero_strain", not_above, "limits.max_strain", "position 0 must be allowed"),
      rule("limits.stress_Pa", below, "trips.stress_Pa", is_first),
      rule("limits.stress_Pa", not_above, "wire.limits.stress_Pa", wire),
      rule("trips.slack_Pa", below, "limits.stress_Pa", between),
      rule("drive.min_supply_V", below, "drive.max_supply_V", between),
      rule("profile.loop_s", below, "profile.cycle_s", "an inner loop is part of a cycle"),
      rule("wire.heat.latent_r2a_J_kg", not_above, "wire.heat.latent_m2a_J_kg",
           "a closed cycle would create heat"),
      rule("wire.m2a.start_0_K", heats, "wire.m2a.finish_0_K", detail::heats),
      rule("wire.a2m.start_0_K", cools, "wire.a2m.finish_0_K", detail::cools),
      rule("wire.a2r.start_0_K", cools, "wire.a2r.finish_0_K", detail::cools),
      rule("wire.r2a.start_0_K", heats, "wire.r2a.finish_0_K", detail::heats),
      rule("wire.r2m.start_0_K", cools, "wire.r2m.finish_0_K", detail::cools),
      rule("wire.m2a.curvature_0", curvature, "wire.m2a.curvature_1_1_Pa", curves),
      rule("wire.a2m.curvature_0", curvature, "wire.a2m.curvature_1_1_Pa", curves),
      rule("wire.a2r.curvature_0", curvature, "wire.a2r.curvature_1_1_Pa", curves),
      rule("wire.r2a.curvature_0", curvature, "wire.r2a.curvature_1_1_Pa", curves),
      rule("wire.r2m.curvature_0", curvature, "wire.r2m.curvature_1_1_Pa", curves),
      rule("wire.m2a.turning_0", turning, "wire.m2a.turning_1_1_Pa", turns),
      rule("wire.a2m.turning_0", turning, "wire.a2m.turning_1_1_Pa", turns),
      rule("wire.a2r.turning_0", turning, "wire.a2r.turning_1_1_Pa", turns),
      rule("wire.r2a.turning_0", turning, "wire.r2a.turning_1_1_Pa", turns),
      rule("wire.r2m.turning_0", turning, "wire.r2m.turning_1_1_Pa", turns),
  });
}

/// The surface that a row belongs to, by the row's index.
template <class S>
Surface<S> surface_of(const ThreePhaseParams<S>& p, std::uint16_t index) {
  switch (index) {
    case 0x2112:
      return first_surface(p.a2m_a2r);
    case 0x2113:
      return second_surface(p.a2m_a2r);
    case 0x2114:
      return p.r2a;
    case 0x2115:
      return p.r2m;
    default:
      return p.m2a;
  }
}

template <class S>
bool surface_holds(const Surface<S>& surface, Relation relation, const S& stress_Pa) {
  constexpr SurfaceRange range;
  const Isobar<S> at = isobar(surface, stress_Pa);
  // A value at the edge of the range of a wire file may be rounded beyond it.
  const auto within = [](const S& min, const S& x, const S& max) {
    const S slack = S(1e-3) * min;
    return min - slack <= x && x <= max + slack;
  };
  if (relation == Relation::curvature) {
    return within(S(range.min_curvature), at.shape.curvature, S(range.max_curvature));
  }
  if (relation == Relation::turning) {
    return within(S(range.min_turning), at.shape.turning, S(range.max_turning));
  }
  const S span_K = S(1) / at.per_K;
  const S min_K = S(range.min_K);
  const S max_K = S(range.max_K);
  return within(S(range.min_span_K), relation == Relation::heats ? span_K : -span_K,
                S(range.max_K - range.min_K)) &&
         within(min_K, at.start_K, max_K) && within(min_K, at.start_K + span_K, max_K);
}

template <class S>
bool process_holds(const RuleRow& rule, const Wire<S>& wire) {
  const Surface<S> surface = surface_of(wire.kinetics, parameter_rows<S>[rule.a].key.index);
  constexpr int parts = surface_range.stresses - 1;
  for (int i = 0; i <= parts; ++i) {
    if (!surface_holds(surface, rule.relation, wire.limits.stress_Pa * S(i) / S(parts))) {
      return false;
    }
  }
  return true;
}

/// Relation idle_power or idle_heat: P = I^2 R of a wire at rest at 25 °C.
template <class S>
bool idles(Relation relation, const Wire<S>& wire, const S& current_A, const S& b, const S& plus) {
  const S idle_W = current_A * current_A * cold_resistance_ohm(wire);
  const S above_K = b - plus - S(room_K);
  const S allowed_W =
      relation == Relation::idle_power
          ? b
          : S(max_idle_share) * thermal_body(wire.geometry, wire.heat).loss_W(above_K);
  return !(allowed_W < idle_W);  // NaN fulfils the rule: the wire is not configured
}

}  // namespace detail

inline constexpr auto parameter_rules = detail::all_rules();

/// The rules without their texts.
inline constexpr auto rule_rows = [] {
  std::array<RuleRow, parameter_rules.size()> rows{};
  std::ranges::copy(parameter_rules, rows.begin());
  return rows;
}();

/// Whether this parameter has a value: it has a default, or its value is not NaN.
template <class S>
bool is_set(const ParameterRow<S>& row, const Settings<S>& settings) {
  return row.has_default() || !std::isnan(row.get(settings).real());
}

/// Row of the first parameter without which the device is not configured; no_parameter if there is
/// none.
template <class S>
std::size_t first_missing(const Settings<S>& settings) {
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const ParameterRow<S>& row = parameter_rows<S>[i];
    if (row.is_used(settings) && !is_set(row, settings)) {
      return i;
    }
  }
  return no_parameter;
}

template <class S>
bool holds(const RuleRow& rule, const Settings<S>& settings) {
  const auto known = [&](std::size_t i) {
    return i == no_parameter ||
           (parameter_rows<S>[i].is_used(settings) && is_set(parameter_rows<S>[i], settings));
  };
  const auto value = [&](std::size_t i) { return parameter_rows<S>[i].get(settings).real(); };
  if (!known(rule.a) || !known(rule.b) || !known(rule.plus)) {
    return true;
  }
  if (rule.relation == Relation::idle_power || rule.relation == Relation::idle_heat) {
    return detail::idles(rule.relation, settings.wire, S(value(rule.a)), S(value(rule.b)),
                         rule.plus < parameter_count ? S(value(rule.plus)) : S(0));
  }
  if (rule.relation != Relation::below && rule.relation != Relation::not_above) {
    return !(settings.wire.limits.stress_Pa == settings.wire.limits.stress_Pa) ||
           detail::process_holds(rule, settings.wire);
  }
  const float a =
      rule.factor * value(rule.a) + (rule.plus < parameter_count ? value(rule.plus) : 0);
  return rule.relation == Relation::below ? a < value(rule.b) : a <= value(rule.b);
}

constexpr Problem problem_of(Fit fit) {
  return fit == Fit::inside       ? Problem::none
         : fit == Fit::not_finite ? Problem::not_finite
         : fit == Fit::below      ? Problem::below
                                  : Problem::above;
}

/// The first problem of the settings. A parameter that is not set yet is no problem here: see
/// first_missing(). Cost: some ten microseconds on a PC; not for the loop.
template <class S>
Finding check(const Settings<S>& settings) {
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const ParameterRow<S>& row = parameter_rows<S>[i];
    if (!row.is_used(settings) || !is_set(row, settings)) {
      continue;
    }
    const Fit value = fit(row, row.get(settings));
    if (value != Fit::inside) {
      return {problem_of(value), i};
    }
  }
  for (std::size_t i = 0; i < rule_rows.size(); ++i) {
    if (!holds(rule_rows[i], settings)) {
      return {Problem::contradiction, rule_rows[i].a, rule_rows[i].b, i};
    }
  }
  return {};
}

}  // namespace smaservo
