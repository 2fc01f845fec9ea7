#include "host-sim/evaluate/rows.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace smaservo::evaluate {
namespace {

constexpr double nothing_known = std::numeric_limits<double>::quiet_NaN();

/// The smallest value that at least this share of the values do not exceed.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) {
    return nothing_known;
  }
  std::ranges::sort(values);
  const double place = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(place, 1.0)) - 1];
}

}  // namespace

const std::vector<EvaluationRow>& evaluation_rows() {
  using enum Condition;
  static const std::vector<EvaluationRow> rows{
      {.name = "standard",
       .meaning = "100 to 400 MPa, bias spring, varying load",
       .conditions = {constant, spring, varying},
       .mean = 0.4,
       .p95 = 1.2,
       .maximum = 4},
      {.name = "disturbed",
       .meaning = "the same; air ±10 K, convection ±20 %, resistance ±1 %",
       .conditions = {constant, spring, varying},
       .disturbed = Disturbed::always,
       .runs = 84,
       .mean = 0.5,
       .p95 = 1.3,
       .maximum = 6},
      {.name = "light",
       .meaning = "10 to 50 MPa, half of the runs disturbed",
       .conditions = {light},
       .disturbed = Disturbed::every_other,
       .mean = 0.9,
       .p95 = 2.5,
       .maximum = 8},
      {.name = "uncalibrated",
       .meaning = "as standard, with the type's parameters and one measured resistance",
       .conditions = {constant, spring, varying},
       .known = Known::type,
       .mean = 2.2,
       .p95 = 7,
       .maximum = 14},
      {.name = "commissioned",
       .meaning = "as uncalibrated, after one run without a displacement sensor",
       .conditions = {constant, spring, varying},
       .known = Known::commissioned,
       .mean = 1.5},
      {.name = "two-readings",
       .meaning = "as commissioned, and the wire's length read twice in that run",
       .conditions = {constant, spring, varying},
       .known = Known::two_readings,
       .mean = 1.0},
      {.name = "uncalibrated-stroke",
       .meaning = "as uncalibrated, errors of the displacement since the cold start",
       .conditions = {constant, spring, varying},
       .known = Known::type,
       .counted = Counted::displacement},
      {.name = "read-stroke",
       .meaning = "the same, after one run in which the stroke was read",
       .conditions = {constant, spring, varying},
       .known = Known::read_stroke,
       .counted = Counted::displacement,
       .mean = 1.0},
      {.name = "unknown-start",
       .meaning = "begins in the middle of a motion, 50 to 400 MPa",
       .conditions = {unknown_start}},
      {.name = "hold",
       .meaning = "held for 20 s, the power ripples by 50 % at 2 Hz",
       .conditions = {hold_ripple}},
      {.name = "gust",
       .meaning = "held, then the air cools 0.5 to 3 times as much for 10 s",
       .conditions = {gust},
       .p95 = 3},
      {.name = "coarse", .meaning = "constant load, 12 bits, 100 Hz", .conditions = {coarse}}};
  return rows;
}

std::string run_text(const EvaluatedRun& run) {
  return fmt::format("{} {}, {}{}, seed {}", hal::family_name(run.family), run.unit,
                     condition_name(run.condition), run.disturbed ? " disturbed" : "", run.seed);
}

void PooledRuns::add(const JudgedRun& run) {
  const RunFigures& f = run.figures;
  ++sums_.runs;
  sums_.error.add(f.error);
  sums_.lost += f.lost ? 1 : 0;
  with_sd_ += f.with_sd;
  within_2_sd_ += f.within_2_sd;
  if (run.run.condition == Condition::hold_ripple) {
    drifts_.push_back(std::abs(run.drift_percent));
  }
  if (run.start) {
    found_s_.push_back(run.start->found_after_s);
    sums_.locked += run.start->locked ? 1 : 0;
    sums_.unsure += run.start->sure ? 0 : 1;
  }
}

RowFigures PooledRuns::figures() const {
  RowFigures row = sums_;
  row.within_2_sd = with_sd_ == 0
                        ? nothing_known
                        : static_cast<double>(within_2_sd_) / static_cast<double>(with_sd_);
  row.drift_mean = drifts_.empty() ? nothing_known
                                   : std::accumulate(drifts_.begin(), drifts_.end(), 0.0) /
                                         static_cast<double>(drifts_.size());
  row.drift_p95 = quantile(drifts_, 0.95);
  row.drift_maximum = quantile(drifts_, 1);
  row.found_median_s = quantile(found_s_, 0.5);
  row.found_p90_s = quantile(found_s_, 0.9);
  return row;
}

}  // namespace smaservo::evaluate
