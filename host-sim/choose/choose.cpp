#include "host-sim/choose/choose.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <variant>

#include "host-sim/choose/air.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::choose {
namespace {

/// The share of what a wire could contract that is used: the end of the curve takes long and hot.
constexpr double used = 0.95;
/// The share of the stroke that may be missing when the wire counts as stretched.
constexpr double left = 0.05;
/// A proposed spring pulls by this share more on the contracted wire than on the cold one.
constexpr double spring_rise = 0.25;
/// A wire that moves by less of its length is not cold in this air: it would have to be long, and
/// the end of its curve takes long.
constexpr double least_usable = 0.02;

/// What stretches a wire may be less than the maker's figure by this share, which he calls a good
/// starting point.
constexpr double tolerance = 0.05;

/// What a wire has to pass, in this order.
enum class Stage : unsigned char { force, stretching, stroke, heat, voltage };

/// Why a wire does not do it, and at which stage it fails.
class Why : public std::runtime_error {
 public:
  Why(Stage stage_, const std::string& text) : std::runtime_error(text), stage(stage_) {}
  Stage stage;
};

double MPa(double stress_Pa) {
  return 1e-6 * stress_Pa;
}

double cold_ends_m(const Wire<double>& wire) {
  return cold_ends(wire.geometry, wire.heat, wire.kinetics).share * wire.geometry.length_m;
}

/// What pulls on one of `n` wires of this kind. Throws Why.
struct Loads {
  Pull pull;
  std::optional<Spring> spring;  ///< of all wires together
};
Loads loads_of(const Task& task, const MakersWire& maker, int n) {
  Loads loads{{task.force_N / n, !task.one_way, 0, 0}, task.spring};
  const double missing_N = maker.stretching_load_N - loads.pull.cold_N();
  if (!task.spring && missing_N > tolerance * maker.stretching_load_N) {
    loads.spring = Spring{n * missing_N, n * spring_rise * missing_N / task.stroke_m};
  }
  if (loads.spring) {
    loads.pull.preload_N = loads.spring->preload_N / n;
    loads.pull.rate_N_m = loads.spring->rate_N_m / n;
  }
  const double area_m2 = maker.wire.geometry.area_m2();
  const double most_N = maker.allowed_load_N(task.life);
  const double pulled_N = loads.pull.contracted_N(task.stroke_m);
  // The forces of the tables have two digits.
  constexpr double rounded = 1.005;
  if (pulled_N > rounded * most_N) {
    throw Why(
        Stage::force,
        fmt::format("{:.4g} N{}: {:.0f} MPa; {}: {:.0f} MPa", n * pulled_N,
                    loads.spring ? " with its spring" : "", MPa(pulled_N / area_m2),
                    task.life == Life::many ? "suggested" : "allowed", MPa(most_N / area_m2)));
  }
  if (loads.pull.cold_N() < (1 - tolerance) * maker.stretching_load_N) {
    throw Why(Stage::stretching, fmt::format("{:.3g} N do not stretch the cold wire; {:.3g} N do",
                                             n * loads.pull.cold_N(), n * maker.stretching_load_N));
  }
  return loads;
}

/// A wire of the length that the stroke needs. Throws Why.
CycleTask cycle_of(const Task& task, const MakersWire& maker, const Loads& loads) {
  CycleTask cycle{maker.wire, loads.pull, task.stroke_m, task.ambient_K};
  double& length_m = cycle.wire.geometry.length_m;
  const double allowed = maker.allowed_stroke(task.life, loads.spring.has_value());
  const auto usable = [&] {
    return std::min(allowed, used * greatest_contraction_m(cycle) / length_m);
  };
  // The clamps cool both ends; where they are more than a quarter of the wire, it is not a wire of
  // one temperature any more.
  const double shortest_m = 4 * cold_ends_m(cycle.wire);
  const auto require_motion = [&] {
    if (usable() < least_usable) {
      throw Why(Stage::stroke,
                fmt::format("moves by {:.2g} % only, in air of {:.3g} °C",
                            100 * std::max(0.0, usable()), task.ambient_K - zero_degC_K));
    }
  };
  if (!task.length_m) {
    length_m = 1;
    constexpr int rounds = 4;
    for (int i = 0; i < rounds; ++i) {
      require_motion();
      length_m = std::max(shortest_m, task.stroke_m / usable());
    }
    // Up to a whole millimetre, or three digits.
    const double unit_m = std::min(1e-3, std::pow(10, std::floor(std::log10(length_m)) - 2));
    length_m = std::ceil(length_m / unit_m * (1 - 1e-9)) * unit_m;
    return cycle;
  }
  length_m = *task.length_m;
  if (length_m < shortest_m) {
    throw Why(Stage::stroke, fmt::format("its clamps cool too much of {:.3g} mm; {:.3g} mm do",
                                         1e3 * length_m, 1e3 * shortest_m));
  }
  require_motion();
  if (task.stroke_m > usable() * length_m * (1 + 1e-9)) {
    throw Why(Stage::stroke,
              fmt::format("{:.3g} mm are {:.2f} % of its length; it may move {:.2f} %",
                          1e3 * task.stroke_m, 100 * task.stroke_m / length_m, 100 * usable()));
  }
  return cycle;
}

Suitable suitable(const Task& task, const MakersWire& maker, int n) {
  const Loads loads = loads_of(task, maker, n);
  const CycleTask cycle = cycle_of(task, maker, loads);
  const std::optional<Contracted> hot = contract(cycle, task.time_s);
  if (!hot) {
    throw Why(Stage::heat, fmt::format("passes {:.0f} °C before it has contracted",
                                       cycle.wire.limits.temperature_K - zero_degC_K));
  }
  const Geometry<double>& geometry = cycle.wire.geometry;
  Suitable s;
  s.wire = maker.preset;
  s.parallel = n;
  s.length_m = geometry.length_m;
  s.strain = task.stroke_m / geometry.length_m;
  s.stress_Pa = loads.pull.contracted_N(task.stroke_m) / geometry.area_m2();
  s.cold_stress_Pa = loads.pull.cold_N() / geometry.area_m2();
  s.current_A = hot->current_A;
  s.voltage_V = n * hot->current_A * hot->ohm;
  s.power_W = s.voltage_V * hot->current_A;
  s.hold_A = hot->hold_A;
  s.hottest_K = hot->temperature_K;
  s.overheats_s = hot->overheats_s;
  s.spring = loads.spring;
  s.cycles = maker.cycles(task.life);
  s.makers_current_A = maker.current_1s_A;
  s.makers_cooling_s = maker.cooling_s;
  if (task.supply_V && s.voltage_V > *task.supply_V) {
    throw Why(Stage::voltage,
              fmt::format("needs {:.3g} V to contract in {:.3g} s", s.voltage_V, task.time_s));
  }
  s.seconds = hot->seconds;
  s.heating = hot->course;
  s.back_still_s = stretch_again(cycle, *hot, 1, left * task.stroke_m, &s.still);
  s.back_fan_s = stretch_again(
      cycle, *hot,
      fan_draught(geometry.diameter_m, task.fan_m_s, hot->temperature_K, task.ambient_K),
      left * task.stroke_m, &s.fan);
  return s;
}

/// The name is that of the option, and its unit.
void require_range(const char* name, double value, double low, double high) {
  if (!(low <= value && value <= high)) {
    throw files::UserError(
        fmt::format("{} = {:.6g}: must be between {:.6g} and {:.6g}", name, value, low, high));
  }
}

void check(const Task& t) {
  require_range("force_N", t.force_N, 0, 1000);
  require_range("stroke_mm", 1e3 * t.stroke_m, 1e-3, 1000);
  require_range("time_s", t.time_s, 0.01, 60);
  require_range("length_mm", 1e3 * t.length_m.value_or(0.1), 1, 1e5);
  require_range("supply_V", t.supply_V.value_or(1), 0.01, 1000);
  require_range("ambient_degC", t.ambient_K - zero_degC_K, -40, 100);
  require_range("fan_m_s", t.fan_m_s, 0, 50);
  require_range("parallel", t.parallel, 1, most_parallel);
  if (t.spring) {
    require_range("spring: preload_N", t.spring->preload_N, 0, 1000);
    require_range("spring: rate_N_mm", 1e-3 * t.spring->rate_N_m, 0, 1000);
  }
}

/// The fewest wires of this kind that do it, or the reason why those that come furthest do not.
std::variant<Suitable, Unsuitable> fewest(const Task& task, const MakersWire& maker) {
  Unsuitable furthest;
  int passed = -1;
  for (int n = 1; n <= task.parallel; ++n) {
    try {
      return suitable(task, maker, n);
    } catch (const Why& why) {
      if (passed < static_cast<int>(why.stage)) {
        furthest = {name_of(n, maker.preset), why.what()};
        passed = static_cast<int>(why.stage);
      }
      if (why.stage == Stage::voltage) {
        break;  // more wires in series need more
      }
    }
  }
  return furthest;
}

}  // namespace

std::string name_of(int parallel, const std::string& wire) {
  return parallel == 1 ? wire : fmt::format("{} x {}", parallel, wire);
}

Choice choose_wires(const Task& task, const std::function<bool()>& ended) {
  check(task);
  Choice choice;
  for (const MakersWire& maker : makers_wires()) {
    if (ended()) {
      throw files::UserError("was ended");
    }
    auto result = fewest(task, maker);
    if (auto* const found = std::get_if<Suitable>(&result)) {
      choice.suitable.push_back(std::move(*found));
    } else {
      choice.others.push_back(std::get<Unsuitable>(std::move(result)));
    }
  }
  std::ranges::sort(choice.suitable, {},
                    [](const Suitable& s) { return std::tie(s.power_W, s.wire); });
  return choice;
}

std::vector<MakersCheck> check_makers() {
  std::vector<MakersCheck> all;
  for (const MakersWire& maker : makers_wires()) {
    if (!maker.cooling_s || !maker.current_1s_A) {
      continue;
    }
    CycleTask task{maker.wire, {maker.suggested_load_N, true, 0, 0}, 0, room_K};
    constexpr double share = 0.9;
    task.contraction_m = share * greatest_contraction_m(task);
    std::optional<Contracted> hot = contract(task, 1);
    if (!hot) {
      throw std::logic_error(maker.preset + " does not contract in a second");
    }
    // From here on the length counts that the wire has under the lesser load.
    CycleTask stretched = task;
    stretched.pull.load_N = maker.stretching_load_N;
    hot->rest_strain = WirePlant<double>(maker.wire, maker.stretching_load_N).output().strain;
    const auto cooling_s = stretch_again(stretched, *hot, 1, 0.005 * maker.wire.geometry.length_m);
    all.push_back({maker.preset, *maker.current_1s_A, hot->current_A, *maker.cooling_s,
                   cooling_s.value_or(longest_stretch_s)});
  }
  return all;
}

}  // namespace smaservo::choose
