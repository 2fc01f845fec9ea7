#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "host-sim/checks/findings.hpp"
#include "host-sim/checks/statistics.hpp"

namespace smaservo::checks {
namespace {

/// Of a wire in air that moves.
constexpr double moving_air_W_m2K = 200;

double cooling_s(const Geometry<double>& geometry) {
  return density_kg_m3 * specific_heat_J_kgK * geometry.diameter_m / (4 * moving_air_W_m2K);
}

Values steps_of(const Values& time_s) {
  Values steps(time_s.size());
  std::adjacent_difference(time_s.begin(), time_s.end(), steps.begin());
  steps.erase(steps.begin());
  return steps;
}

std::string option_for(const Place& place, std::string_view unit) {
  if (place.column == 0) {
    return "check --period-s";
  }
  if (place.unit == unit) {
    return fmt::format("check the times in column {} '{}'", place.column, place.name);
  }
  return fmt::format("if column {} '{}' is in {}: --column time={}:{}", place.column, place.name,
                     unit, place.column, unit);
}

/// The voltage of a resistance that is the same in neighbouring rows, had it been measured `shift`
/// steps after the current: V = R (I + shift (I' - I)). Least squares over the rows where the
/// current changes.
struct Shift {
  double steps = 0;
  double explained = 0;  ///< the share of what differs from V = R I
  std::size_t rows = 0;
};

Shift shift_of(const Record& record) {
  double largest_A = 0;
  for (const double current_A : record.current_A) {
    largest_A = std::max(largest_A, std::abs(current_A));
  }
  const auto resistance = [&](std::size_t i) { return record.voltage_V[i] / record.current_A[i]; };
  double xx = 0, xy = 0, yy = 0;
  Shift shift;
  for (std::size_t i = 2; i + 2 < record.current_A.size(); ++i) {
    const double before_A = record.current_A[i - 1], now_A = record.current_A[i];
    const double jump_A = record.current_A[i + 1] - now_A;
    const bool steady = std::abs(now_A - before_A) < 0.01 * largest_A &&
                        std::abs(before_A - record.current_A[i - 2]) < 0.01 * largest_A;
    if (std::abs(jump_A) < 0.1 * largest_A || !steady || before_A < 0.1 * largest_A) {
      continue;
    }
    // The row before the jump has the voltage of a moment after it, or the row behind the jump
    // that of a moment before.
    const double ohm = resistance(i - 1);
    const double early_A = record.voltage_V[i] / ohm - now_A;
    const double late_A = record.voltage_V[i + 1] / ohm - record.current_A[i + 1];
    const double off_A = std::abs(early_A) > std::abs(late_A) ? early_A : late_A;
    xx += jump_A * jump_A;
    xy += jump_A * off_A;
    yy += off_A * off_A;
    ++shift.rows;
  }
  if (shift.rows > 0 && yy > 0) {
    shift.steps = xy / xx;
    shift.explained = xy * xy / (xx * yy);
  }
  return shift;
}

void check_sampling(const Record& record, double step_s, Findings& found) {
  constexpr std::size_t enough = 5;
  if (record.kind != RunKind::joule || record.current_A.size() != record.voltage_V.size()) {
    return;
  }
  const Shift shift = shift_of(record);
  if (shift.rows >= enough && shift.explained > 0.8 && std::abs(shift.steps) > 0.15) {
    found.push_back(
        {"sampling", false,
         fmt::format("the voltage was measured about {:.2g} ms {} the current, as {} jumps of the "
                     "current show: where it jumps by half, the resistance is wrong by up to "
                     "{:.0f} %; record both at the same moment",
                     1e3 * step_s * std::abs(shift.steps), shift.steps > 0 ? "after" : "before",
                     shift.rows, 50 * std::abs(shift.steps))});
  }
}

}  // namespace

void check_time(const Record& record, const RecordedWire& wire, Findings& found) {
  if (record.kind != RunKind::joule || record.time_s.size() < 2) {
    return;
  }
  const Values steps = steps_of(record.time_s);
  const double step_s = range_of(steps).middle;
  const double duration_s = record.time_s.back() - record.time_s.front();
  const double cools_s = cooling_s(wire.geometry);
  const Place& place = record.places[static_cast<std::size_t>(hal::Column::time)];
  const std::string_view finer = place.unit == "s" ? "ms" : "us";
  const std::string_view coarser = place.unit == "us" ? "ms" : "s";
  // A few rows may be settled states, written down one by one.
  constexpr std::size_t by_hand = 200;
  if (step_s > std::max(3 * cools_s, 1.0)) {
    found.push_back(
        {"time", record.time_s.size() > by_hand,
         fmt::format("half of the rows or more come at least {:.4g} s after the one before, and a "
                     "wire of {:.4g} um cools within {:.2g} s; {}{}",
                     step_s, 1e6 * wire.geometry.diameter_m, 3 * cools_s, option_for(place, finer),
                     record.time_s.size() > by_hand
                         ? ""
                         : "; where each row is a settled state, nothing is wrong")});
  } else if (duration_s < 0.05 * cools_s) {
    found.push_back(
        {"time", true,
         fmt::format("all {} rows are within {:.3g} s, in which a wire of {:.4g} um neither heats "
                     "up nor cools (it takes {:.2g} s); {}",
                     record.time_s.size(), duration_s, 1e6 * wire.geometry.diameter_m, cools_s,
                     option_for(place, coarser))});
  }
  check_sampling(record, step_s, found);
}

}  // namespace smaservo::checks
