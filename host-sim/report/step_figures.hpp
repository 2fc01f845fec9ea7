#pragma once
// Figures that show how a wire followed the set-points of a strain loop, step by step.

#include <cmath>
#include <cstdint>
#include <vector>

#include "model/files/text_table.hpp"

namespace smaservo::report {

/// The response to one set-point. Percentages relate to the nominal stroke and to the true strain.
/// NaN if the response did not get there.
struct StepFigures {
  double from_s;
  double seconds;
  double from, to;  ///< true strain at the beginning of the step; set-point
  /// Time from 10 to 90 % of the way; only for steps of at least 2 % of the stroke.
  double rise_s;
  double settling_s;         ///< time until the strain stays within +-2 % of the stroke
  double overshoot_percent;  ///< greatest excess over the set-point; 0: none
  double error_percent;      ///< mean magnitude over the last quarter
  double end;                ///< strain at the end
  double held;               ///< set-point in force at the end, as limits have left it
  double estimate;           ///< at the end
  std::uint32_t limits;      ///< bits that were set in at least half of the last quarter
};

/// Whether the response ended outside of +-2 % of the stroke around its set-point.
inline bool is_unreached(const StepFigures& step) {
  return std::isnan(step.settling_s);
}

/// What a controller knows and does.
struct StepControl {
  double held;           ///< set-point in force
  double estimate;       ///< of the strain
  std::uint32_t limits;  ///< a bit for each limit that acts
};

/// Takes a run at equal time steps. Set-points that last less than 0.2 s are not counted as steps.
class StepJudge {
 public:
  StepJudge(double stroke, double period_s) : stroke_(stroke), period_s_(period_s) {}

  /// A set-point of NaN means that the strain is not controlled.
  void add(double time_s, double setpoint, double strain, const StepControl& control);
  /// The same of a strain that is measured, and without limits.
  void add(double time_s, double setpoint, double strain) {
    add(time_s, setpoint, strain, {setpoint, strain, 0});
  }
  /// Ends the last step.
  void finish();
  const std::vector<StepFigures>& steps() const { return steps_; }

 private:
  StepFigures judged() const;
  std::uint32_t lasting_limits(std::size_t last) const;

  double stroke_, period_s_;
  double from_s_ = 0;
  double setpoint_ = 0;
  StepControl control_{};
  std::vector<double> strains_;
  std::vector<std::uint32_t> limits_;
  std::vector<StepFigures> steps_;
};

files::TextTable steps_table(const std::vector<StepFigures>& steps);

}  // namespace smaservo::report
