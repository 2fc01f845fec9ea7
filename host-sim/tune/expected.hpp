#pragma once
// Expected steps of the strain: the device's own step on lumped wires that differ slightly from
// that of the file.

#include <functional>
#include <vector>

#include "firmware/faults.hpp"
#include "host-sim/tune/proposal.hpp"

namespace smaservo::tune {

/// One step of the set-point and the wire's response.
struct StepResponse {
  double from, to;  ///< set-points, as strains
  double begins_s;
  double rise_s;  ///< time from 10 to 90 % of the way that the strain went
  /// Time until the strain stays within 2 % of the nominal stroke around its final value.
  double settling_s;
  double overshoot;     ///< greatest excess over the final value, as a strain
  double steady_error;  ///< mean of the last 30 % less the set-point, as a signed strain
  double ripple;  ///< peak to peak in the last 30 %: a limit cycle, if more than the dead band
  double hottest_K;
};

struct ExpectedRun {
  std::size_t member;
  FaultSet faults;  ///< why the device has tripped, or could not be armed in time
  std::vector<StepResponse> steps;
  std::vector<double> strain, temperature_K, current_A;  ///< value in each period, on the real wire
};

struct ExpectedSteps {
  double period_s;
  std::vector<double> setpoint;
  std::vector<ExpectedRun> runs;  ///< the first is that of the file's wire
};

/// Steps to 50, 85, 40 and 15 % of the contraction, with the sensors' noise and one period between
/// a sample and its current. The device assumes the ambient temperature of the file's plant.
/// `progress` is called with the share of the wires that are done, 0 to 1.
ExpectedSteps expected_steps(
    const TuneTask& task, const Proposal& p, const std::vector<TunedPlant>& plants,
    const std::function<void(double)>& progress = [](double) {});

/// The worst value of each number over all runs, step by step.
std::vector<StepResponse> worst_steps(const ExpectedSteps& expected);

/// The number of wires that do not settle: the strain still moves by more than 2.5 % of the nominal
/// stroke in the last 30 % of a step, or its mean there is off by more than 20 %; or the wire was
/// hotter than the limit; or the device tripped or could not be armed.
int restless_wires(const ExpectedSteps& expected, const Settings<double>& settings);

/// Judges one step by the strain between two samples of a run.
StepResponse judge_step(const std::vector<double>& strain, std::size_t first, std::size_t last,
                        double from, double to, double period_s, double band);

}  // namespace smaservo::tune
