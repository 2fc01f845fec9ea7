#include "host-sim/papers/figures/002/position_loop_002.hpp"

#include <cmath>
#include <random>

#include "host-sim/papers/figures/002/rig_002.hpp"

namespace smaservo::figures::bench_002 {
PidGains gains() {
  return {16, 16, 1.5, min_current_A, wire().wire.limits.current_A};
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
