#include "host-sim/report/step_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace smaservo::report {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double min_step_s = 0.2;
constexpr double settled_percent = 2;
constexpr double min_rise_percent = 2;

}  // namespace

void StepJudge::add(double time_s, double setpoint, double strain, const StepControl& control) {
  if (strains_.empty() || setpoint != setpoint_) {
    finish();
    from_s_ = time_s;
    setpoint_ = setpoint;
  }
  if (!std::isnan(setpoint)) {
    strains_.push_back(strain);
    limits_.push_back(control.limits);
    control_ = control;
  }
}

void StepJudge::finish() {
  if (static_cast<double>(strains_.size()) * period_s_ > min_step_s) {
    steps_.push_back(judged());
  }
  strains_.clear();
  limits_.clear();
}

StepFigures StepJudge::judged() const {
  const auto at_s = [&](std::size_t i) { return static_cast<double>(i) * period_s_; };
  const std::size_t n = strains_.size();
  const std::size_t last = n / 4;
  StepFigures f{.from_s = from_s_,
                .seconds = at_s(n),
                .from = strains_.front(),
                .to = setpoint_,
                .rise_s = unknown,
                .settling_s = unknown,
                .overshoot_percent = 0,
                .error_percent = 0,
                .end = strains_.back(),
                .held = control_.held,
                .estimate = control_.estimate,
                .limits = lasting_limits(last)};
  const double way = f.to - f.from;
  const double sign = way < 0 ? -1 : 1;
  std::size_t outside = 0;  ///< index after the last sample outside of the band
  double ten_s = unknown;
  for (std::size_t i = 0; i < n; ++i) {
    const double error_percent = 100 * (strains_[i] - f.to) / stroke_;
    outside = std::abs(error_percent) > settled_percent ? i + 1 : outside;
    f.overshoot_percent = std::max(f.overshoot_percent, sign * error_percent);
    const double share = (strains_[i] - f.from) / way;
    ten_s = std::isnan(ten_s) && share >= 0.1 ? at_s(i) : ten_s;
    f.rise_s = std::isnan(f.rise_s) && share >= 0.9 ? at_s(i) - ten_s : f.rise_s;
    f.error_percent += i >= n - last ? std::abs(error_percent) : 0;
  }
  f.error_percent /= static_cast<double>(last);
  f.settling_s = outside < n ? at_s(outside) : unknown;
  if (100 * std::abs(way) < min_rise_percent * stroke_) {
    f.rise_s = unknown;
  }
  return f;
}

/// The bits that are set in at least half of the last samples.
std::uint32_t StepJudge::lasting_limits(std::size_t last) const {
  std::uint32_t lasting = 0;
  for (unsigned bit = 0; bit < 32; ++bit) {
    const auto acts = [bit](std::uint32_t limits) { return (limits >> bit & 1U) != 0; };
    const auto count =
        std::count_if(limits_.end() - static_cast<std::ptrdiff_t>(last), limits_.end(), acts);
    lasting |= 2 * static_cast<std::size_t>(count) >= last ? 1U << bit : 0U;
  }
  return lasting;
}

files::TextTable steps_table(const std::vector<StepFigures>& steps) {
  files::TextTable table({{"step at s", "{:.3f}"},
                          {"from %", "{:.3f}", "", 100},
                          {"to %", "{:.3f}", "", 100},
                          {"rise s", "{:.3f}"},
                          {"settling s", "{:.3f}"},
                          {"overshoot %", "{:.2f}"},
                          {"error %", "{:.2f}"}});
  for (const StepFigures& s : steps) {
    table.add(
        {s.from_s, s.from, s.to, s.rise_s, s.settling_s, s.overshoot_percent, s.error_percent});
  }
  return table;
}

}  // namespace smaservo::report
