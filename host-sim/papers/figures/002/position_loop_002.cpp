#include "host-sim/papers/figures/002/position_loop_002.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "host-sim/papers/figures/002/rig_002.hpp"

namespace smaservo::figures::bench_002 {
PidGains gains() {
  return {16, 16, 1.5, min_current_A, wire().wire.limits.current_A};
}

double PidController::current_A(double goal, double strain, double dt_s) {
  constexpr double smoothing_s = 0.02;  // time constant of the low-pass on the derivative
  const double error = strain - goal;
  before_ = first_ ? strain : before_;
  first_ = false;
  const double rise = (strain - before_) / (smoothing_s + dt_s);
  before_ += rise * dt_s;
  const double wanted_A = gains_.proportional_A * error + integral_A_ + gains_.derivative_As * rise;
  const bool above = wanted_A > gains_.max_current_A;
  const bool below = wanted_A < gains_.min_current_A;
  if (!(above && error > 0) && !(below && error < 0)) {
    integral_A_ += gains_.integral_A_s * error * dt_s;
  }
  return std::clamp(wanted_A, gains_.min_current_A, gains_.max_current_A);
}

std::vector<LoopRow> position_loop(hal::Family family,
                                   const papers::StrainResistance<double>::Params& estimator,
                                   int goals, std::uint64_t seed) {
  using Estimator = papers::StrainResistance<double>;
  constexpr int every = 20;
  constexpr double each_s = 22;
  const PidGains limits = gains();
  Rig rig(family, spring());
  Estimator::State s = Estimator::start(estimator, rig.step(min_current_A), Rig::ambient_K);
  const auto step = [&](double current_A) {
    Estimator::advance(estimator, s, rig.step(current_A), Rig::step_s);
  };
  while (rig.time_s() < 15) {
    step(rig.time_s() < 6 ? limits.max_current_A : limits.min_current_A);
  }
  PidController controller(limits);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> position(0.012, 0.032);
  std::vector<LoopRow> rows;
  long tick = 0;
  for (int i = 0; i < goals; ++i) {
    const double goal = position(random);
    for (const long stop = tick + std::lround(each_s / Rig::step_s); tick < stop; ++tick) {
      const double estimate = Estimator::estimate(estimator, s).strain;
      const double current_A = controller.current_A(goal, estimate, Rig::step_s);
      if (tick % every == 0) {
        rows.push_back({static_cast<double>(tick) * Rig::step_s, goal, rig.strain(), estimate,
                        current_A, rig.stress_Pa()});
      }
      step(current_A);
    }
  }
  return rows;
}

}  // namespace smaservo::figures::bench_002
