#include "host-sim/evaluate/closed_loop/loop_runs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "firmware/bench/dice.hpp"

namespace smaservo::evaluate {
namespace {

/// A controller on a wire, and the range of strains of the wire.
class Loop {
 public:
  Loop(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions, std::uint64_t seed)
      : stroke_(known.wire.nominal_stroke),
        bench_(known.unit, conditions, seed),
        controller_(make_loop(kind, known)) {
    const auto* spring = std::get_if<hal::SpringLoad>(&conditions.load);
    const double hot_Pa = spring != nullptr
                              ? spring->high_Pa
                              : std::get<hal::ConstantLoad>(conditions.load).stress_Pa;
    // The first frame is read from the wire at rest.
    const Inputs<double> at_rest = bench_.read();
    longest_ = bench_.truth().strain;
    shortest_ = strain(known.wire.material, Phases<double>{0, 0}, hot_Pa);
    bench_.drive(controller_->current_A(at_rest, longest_, longest_));
    // Makes one full stroke: at rest, hot, and back.
    hold(longest_, 1);
    hold(at(0.05), 1);
    hold(at(0.95), loop_hold_s);
  }

  /// The strain at a share of the range: 0 is the shortest, 1 the longest.
  double at(double share) const { return shortest_ + share * (longest_ - shortest_); }
  double stroke() const { return stroke_; }
  double peak_K() const { return bench_.peak_K(); }
  Fault tripped() const { return controller_->tripped(); }

  /// Returns the strain after the step.
  double step(double goal) {
    const double before = bench_.truth().strain;
    const double current_A = controller_->current_A(bench_.read(), goal, before);
    bench_.drive(std::isfinite(current_A) ? current_A : 0);
    return bench_.truth().strain;
  }

  std::vector<double> hold(double goal, double seconds) {
    std::vector<double> strain(static_cast<std::size_t>(std::lround(seconds / LoopBench::step_s)));
    std::ranges::generate(strain, [&] { return step(goal); });
    return strain;
  }

 private:
  double stroke_;
  LoopBench bench_;
  std::unique_ptr<LoopController> controller_;
  double shortest_ = 0, longest_ = 0;
};

/// The number of reversals of the strain by more than `min`.
int reversals(std::span<const double> strain, double min) {
  int count = 0;
  double lowest = strain.front();
  double highest = strain.front();
  int heading = 0;
  for (const double x : strain) {
    lowest = std::min(lowest, x);
    highest = std::max(highest, x);
    const int now = x - lowest > min ? 1 : highest - x > min ? -1 : 0;
    if (now != 0 && now != heading) {
      count += heading == 0 ? 0 : 1;
      heading = now;
      lowest = highest = x;
    } else if (now != 0) {
      (now > 0 ? lowest : highest) = x;
    }
  }
  return count;
}

LoopStep judge(std::span<const double> strain, double before, double goal, double stroke) {
  const auto percent = [&](double x) { return 100 * x / stroke; };
  const auto unsettled = std::ranges::find_if(strain.rbegin(), strain.rend(), [&](double x) {
    return std::abs(percent(x - goal)) > loop_band_percent;
  });
  const auto last = static_cast<double>(strain.rend() - unsettled);
  const auto tail =
      strain.last(static_cast<std::size_t>(std::lround(loop_steady_over_s / LoopBench::step_s)));
  double sum = 0;
  for (const double x : tail) {
    sum += std::abs(percent(x - goal));
  }
  return {goal < before,
          unsettled == strain.rbegin() ? std::numeric_limits<double>::infinity()
                                       : last * LoopBench::step_s,
          sum / static_cast<double>(tail.size()),
          reversals(tail, 0.01 * loop_ripple_percent * stroke)};
}

}  // namespace

LoopRun run_steps(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                  int steps, std::uint64_t seed) {
  Loop loop(kind, known, conditions, seed);
  bench::Dice dice(seed);
  LoopRun run{};
  double before = loop.at(0.95);
  for (int i = 0; i < steps; ++i) {
    double goal = before;
    while (std::abs(goal - before) < 0.1 * loop.stroke()) {
      goal = loop.at(dice.uniform(0.1, 0.9));
    }
    run.steps.push_back(judge(loop.hold(goal, loop_hold_s), before, goal, loop.stroke()));
    before = goal;
  }
  run.above_limit_K = loop.peak_K() - loop_settings(known.wire).limits.temperature_K;
  run.tripped = loop.tripped();
  return run;
}

double sine_gain_dB(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                    double frequency_Hz, std::uint64_t seed) {
  Loop loop(kind, known, conditions, seed);
  const double middle = loop.at(0.5);
  const double amplitude = 0.1 * loop.stroke();
  loop.hold(middle, loop_hold_s);
  const auto periods = std::max(4L, std::lround(4 * frequency_Hz));
  const auto rows = std::lround(static_cast<double>(periods) / (frequency_Hz * LoopBench::step_s));
  double in_phase = 0;
  double out_of_phase = 0;
  long counted = 0;
  for (long i = 0; i < rows; ++i) {
    const double phase =
        2 * std::numbers::pi * frequency_Hz * static_cast<double>(i) * LoopBench::step_s;
    const double strain = loop.step(middle + amplitude * std::sin(phase)) - middle;
    if (i >= rows / 2) {
      in_phase += strain * std::sin(phase);
      out_of_phase += strain * std::cos(phase);
      ++counted;
    }
  }
  const double got = 2 * std::hypot(in_phase, out_of_phase) / static_cast<double>(counted);
  return 20 * std::log10(got / amplitude);
}

double bandwidth_Hz(LoopKind kind, const KnownUnit& known, const LoopConditions& conditions,
                    std::uint64_t seed) {
  const double factor = 1.05;
  double low_Hz = 0.25;
  double high_Hz = 8;
  while (high_Hz > factor * low_Hz) {
    const double middle_Hz = std::sqrt(low_Hz * high_Hz);
    const bool passes = sine_gain_dB(kind, known, conditions, middle_Hz, seed) > -3;
    (passes ? low_Hz : high_Hz) = middle_Hz;
  }
  return low_Hz;
}

}  // namespace smaservo::evaluate
