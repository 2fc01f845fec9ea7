#include "host-sim/commission/live/sequence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "host-sim/identify/fit/cost/prediction.hpp"
#include "model/files/error.hpp"
#include "model/units.hpp"

namespace smaservo::commission {
namespace {

/// The wire may transform this much earlier or later than that of the settings: wires of one type
/// scatter by some kelvins, and a draught takes as much again.
constexpr double span_margin_K = 15;
/// How far the hottest level is above the transformation, if the limit of the temperature allows
/// it.
constexpr double overheat_above_K = 25;
/// How far it stays below the limit of the temperature: a wire that is pressed against its limit is
/// tested by short cuts of the power, which would disturb the readings.
constexpr double below_limit_K = 2;
/// The lowest levels are this far above the air, so that they differ from a rest.
constexpr double above_air_K = 5;
/// Share of the hottest level's power at rest: a tenth of its current, which measures the
/// resistance and heats by less than 1 K.
constexpr double rest_power_share = 0.01;
/// Least resistance of a wire that has transformed, as a share of the cold one: NiTi loses 8 to
/// 20 %.
constexpr double hot_resistance_share = 0.85;

double celsius(double kelvin) {
  return kelvin - zero_degC_K;
}

[[noreturn]] void cannot_transform(const Prepared<double>& device, const SequenceInputs& in,
                                   double reached_K, double middle_K) {
  const SoftLimits<double>& limits = device.settings.limits;
  const double held_W = device.observer.model.body.loss_W(middle_K + span_margin_K - in.ambient_K);
  const std::string begins = fmt::format(
      "half of the wire of the servo's settings has contracted at {:.0f} degC under "
      "{:.0f} MPa",
      celsius(middle_K), in.stress_Pa / 1e6);
  const double allowed_K = limits.temperature_K - limits.hot_spot_K - below_limit_K;
  if (allowed_K < middle_K) {
    throw files::UserError(
        fmt::format("limits.temperature_K of {:.0f} K (less limits.hot_spot_K) allows {:.0f} degC; "
                    "{}; set limits that suit the wire, as far as its maker allows",
                    limits.temperature_K, celsius(allowed_K), begins));
  }
  throw files::UserError(fmt::format(
      "limits.current_A of {:.3g} A and limits.power_W of {:.3g} W heat the wire to {:.0f} degC in "
      "still air; {}; it needs {:.2g} A and {:.2g} W: read firmware/SAFETY.md, then raise them",
      limits.current_A, limits.power_W, celsius(reached_K), begins,
      std::sqrt(held_W / (hot_resistance_share * in.cold_ohm)), held_W));
}

std::vector<double> spread(double from, double to, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = std::lerp(from, to, static_cast<double>(i) / static_cast<double>(count - 1));
  }
  return values;
}

/// The points at which a person is asked, the most useful first: the hot ends, then the middle of
/// both branches.
struct Asked {
  unsigned cycle;
  LevelKind kind;
  std::size_t level;
};
constexpr std::array<Asked, most_questions> asked_points{{{2, LevelKind::up, levels_up - 1},
                                                          {3, LevelKind::up, levels_up - 1},
                                                          {3, LevelKind::up, levels_up / 2 + 1},
                                                          {3, LevelKind::down, levels_down / 2}}};

bool asks_at(const Asked& point, std::size_t questions) {
  const auto* const end = asked_points.begin() + std::min(questions, most_questions);
  return std::find_if(asked_points.begin(), end, [&](const Asked& a) {
           return a.cycle == point.cycle && a.kind == point.kind && a.level == point.level;
         }) != end;
}

}  // namespace

double Sequence::seconds() const {
  return std::accumulate(levels.begin(), levels.end(), 0.0,
                         [](double sum, const Level& level) { return sum + level.seconds; });
}

Span span_of(const Prepared<double>& device, double stress_Pa) {
  const auto& kinetics = device.observer.model.kinetics;
  const Isobar<double> heating = isobar(kinetics.m2a, stress_Pa);
  const Isobar<Pair<double>> cooling = isobar(kinetics.a2m_a2r, Pair<double>(stress_Pa));
  const Pair<double> finish = cooling.start_K + Pair<double>(1) / cooling.per_K;
  // Austenite becomes martensite or R-phase, whichever begins first.
  return {heating.start_K, heating.start_K + 1 / heating.per_K,
          std::max(cooling.start_K.first(), cooling.start_K.second()),
          std::min(finish.first(), finish.second())};
}

Sequence plan_sequence(const Prepared<double>& device, const SequenceInputs& in,
                       const LevelTimes& times, std::size_t questions) {
  const SoftLimits<double>& limits = device.settings.limits;
  const auto loss_W = [&](double kelvin) {
    return device.observer.model.body.loss_W(kelvin - in.ambient_K);
  };
  const Span span = span_of(device, in.stress_Pa);
  const double hot_ohm = hot_resistance_share * in.cold_ohm;
  const double allowed_K = limits.temperature_K - limits.hot_spot_K - below_limit_K;
  const double allowed_W = std::min(limits.power_W, limits.current_A * limits.current_A * hot_ohm);
  double top_K = std::min(span.heating_finish_K + overheat_above_K, allowed_K);
  if (allowed_W < loss_W(top_K)) {
    top_K = in.ambient_K + identify::settled_above_K(device.observer.model.body, 1.0, allowed_W);
  }
  const double middle_K = (span.heating_start_K + span.heating_finish_K) / 2;
  if (top_K < middle_K) {
    cannot_transform(device, in, top_K, middle_K);
  }
  const double top_W = loss_W(top_K);
  const double rest_W = rest_power_share * top_W;
  const double first_A = first_share * limits.current_A;
  const double first_W = std::min(first_A * first_A * hot_ohm, top_W);
  const double lowest_K = in.ambient_K + above_air_K;

  Sequence sequence{
      {}, top_W, top_K, loss_W(span.heating_finish_K) <= first_W, span.heating_finish_K <= top_K};
  auto& levels = sequence.levels;
  levels.push_back({LevelKind::rest, 0, rest_W, times.rest_s});
  levels.push_back({LevelKind::first, 1, first_W, times.first_s});
  levels.push_back({LevelKind::cool, 1, rest_W, times.cool_s});
  const auto up_K =
      spread(std::max(span.heating_start_K - span_margin_K, lowest_K), top_K, levels_up);
  const double down_from_K = std::clamp(span.cooling_start_K + span_margin_K, lowest_K, top_K);
  const auto down_K =
      spread(down_from_K, std::clamp(span.cooling_finish_K - span_margin_K, lowest_K, down_from_K),
             levels_down);
  for (unsigned cycle = 2; cycle < 2 + staircases; ++cycle) {
    const auto add = [&](LevelKind kind, const std::vector<double>& kelvins, double seconds) {
      for (std::size_t i = 0; i < kelvins.size(); ++i) {
        levels.push_back({kind, cycle, std::max(loss_W(kelvins[i]), rest_W), seconds,
                          asks_at({cycle, kind, i}, questions)});
      }
    };
    add(LevelKind::up, up_K, times.up_s);
    add(LevelKind::down, down_K, times.down_s);
  }
  return sequence;
}

std::string level_text(const Sequence& sequence, std::size_t level) {
  const Level& now = sequence.levels.at(level);
  const auto is_same = [&](const Level& other) { return other.cycle == now.cycle; };
  const auto count = std::ranges::count_if(sequence.levels, is_same);
  const auto begin = sequence.levels.begin();
  const auto place = std::count_if(begin, begin + static_cast<std::ptrdiff_t>(level) + 1, is_same);
  return now.cycle == 0 ? "at rest"
                        : fmt::format("cycle {} of {}, level {} of {}", now.cycle, 1 + staircases,
                                      place, count);
}

}  // namespace smaservo::commission
