#pragma once
// Expected steps of the strain: the device's own step on lumped wires that differ a little from the
// file's.

#include "firmware/faults.hpp"
#include "host-sim/tune/proposal.hpp"

namespace smaservo::tune {

/// One step of the set-point and the wire's response.
struct StepResponse {
  double from, to;  ///< set-points, as strains
  double begins_s;
  double rise_s;        ///< from 10 to 90 % of the way it went
  double settling_s;    ///< until it stays within 2 % of the nominal stroke of where it ends up
  double overshoot;     ///< beyond where it ends up, strain
  double steady_error;  ///< set-point to mean of the last 30 %, strain, signed
  double ripple;        ///< peak to peak there: a limit cycle, if more than the dead band
  double hottest_K;
};

struct ExpectedRun {
  std::size_t member;
  FaultSet faults;  ///< why it has tripped, or could not be armed in time
  std::vector<StepResponse> steps;
  std::vector<double> strain, temperature_K, current_A;  ///< each period, on the real wire
};

struct ExpectedSteps {
  double period_s;
  std::vector<double> setpoint;
  std::vector<ExpectedRun> runs;  ///< the first is the file's wire
};

/// Steps to 50, 85, 40 and 15 % of the contraction, with the sensors' noise and one period between
/// a sample and its current. The device believes in the ambient temperature of the file's plant.
ExpectedSteps expected_steps(const TuneTask& task, const Proposal& p,
                             const std::vector<TunedPlant>& plants);

/// The worst of each number, step by step, over all runs.
std::vector<StepResponse> worst_steps(const ExpectedSteps& expected);

/// The number of wires that do not settle: the strain still moves by more than 2.5 % of the nominal
/// stroke in the last 30 % of a step, or is off by 20 %; or the wire was hotter than the limit; or
/// the device tripped or could not be armed.
int restless_wires(const ExpectedSteps& expected, const Settings<double>& settings);

/// Judges one step by the strain between two samples of a run.
StepResponse judge_step(const std::vector<double>& strain, std::size_t first, std::size_t last,
                        double from, double to, double period_s, double band);

}  // namespace smaservo::tune
