#pragma once
// The bench of paper 002 in single steps, for experiments that make decisions while they run.

#include <memory>
#include <random>
#include <vector>

#include "hal/sim/simulated_bench.hpp"
#include "host-sim/papers/figures/002/bench_002.hpp"

namespace smaservo::figures::bench_002 {

class Rig {
 public:
  static constexpr double step_s = 1e-3;
  static constexpr double ambient_K = room_K;

  Rig(hal::Family family, const hal::Load& load);

  /// Makes one step of 1 ms; returns the readings before it.
  Measurement<double> step(double current_A);

  double time_s() const { return time_s_; }
  double strain() const { return wire_->strain(); }
  double resistance_ohm() const { return wire_->resistance_ohm(); }
  double temperature_K() const { return wire_->average_K(); }
  double stress_Pa() const { return load_.stress_Pa(); }

 private:
  double area_m2_;
  hal::LoadModel load_;
  std::mt19937_64 random_{5};
  std::normal_distribution<double> normal_;
  std::unique_ptr<hal::SimulatedWire> wire_;
  double time_s_ = 0;
};

struct RigRow {
  double time_s, strain, resistance_ohm, temperature_K;
  bool heats;
};

/// Section 3.1: a square pulse of current, then cooling to the end. Returns the second pulse, which
/// begins on the major loop.
std::vector<RigRow> major_loop(hal::Family family, double load_N);

/// Section 3.3: on-off feedback to a series of positions between hot and cold. With incomplete
/// cooling the wire is fully heated in between, with incomplete heating fully cooled. `run` has the
/// same data, with one row for each of `rows`.
struct MinorLoops {
  std::vector<RigRow> rows;
  identify::Run run;
};
MinorLoops minor_loops(hal::Family family, double load_N, bool incomplete_cooling);

}  // namespace smaservo::figures::bench_002
