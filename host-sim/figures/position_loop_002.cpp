#include "host-sim/figures/position_loop_002.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "host-sim/simulated_bench.hpp"

namespace smaservo::bench_002 {
namespace {

constexpr double step_s = 1e-3;
constexpr double ambient_K = 298.15;

/// Wire, spring, sensors and estimator.
class Bench {
 public:
  using Observer = StrainResistance<double>;

  Bench(Family family, const Observer::Params& estimator)
      : estimator_(estimator),
        area_m2_(wire().wire.geometry.area_m2()),
        load_(Load{spring()}),
        random_(5),
        wire_(make_simulated_wire(family, wire().wire, {}, 0.5, random_)) {
    wire_->rest(ambient_K, load_.stress_Pa());
    state_ = Observer::start(estimator_, measure(least_current_A), ambient_K);
  }

  void step(double current_A) {
    load_.advance(time_s_, step_s, wire_->strain(), random_);
    Observer::advance(estimator_, state_, measure(current_A), step_s);
    wire_->advance(current_A, {load_.stress_Pa(), ambient_K, 1}, step_s);
    time_s_ += step_s;
  }
  void step_for(double seconds, double current_A) {
    for (long i = std::lround(seconds / step_s); i > 0; --i) {
      step(current_A);
    }
  }

  double strain() const { return wire_->strain(); }
  double estimate() const { return Observer::estimate(estimator_, state_).strain; }
  double stress_Pa() const { return load_.stress_Pa(); }

 private:
  Measurement<double> measure(double current_A) {
    const Readings r = read_sensors(sensors(), current_A, wire_->resistance_ohm(),
                                    load_.stress_Pa() * area_m2_, normal_, random_);
    return {r.voltage_V / r.current_A, 0, 0, r.load_N / area_m2_, true, false, true};
  }

  Observer::Params estimator_;
  double area_m2_;
  LoadModel load_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::unique_ptr<SimulatedWire> wire_;
  Observer::State state_{};
  double time_s_ = 0;
};

}  // namespace

PidGains gains() {
  return {8, 12, 0.4, least_current_A, wire().wire.limits.current_A};
}

double PidController::current_A(double goal, double strain, double dt_s) {
  constexpr double smoothing_s = 0.02;  // of the derivative
  const double error = strain - goal;
  before_ = first_ ? strain : before_;
  first_ = false;
  const double rise = (strain - before_) / (smoothing_s + dt_s);
  before_ += rise * dt_s;
  const double wanted_A = gains_.proportional_A * error + integral_A_ + gains_.derivative_As * rise;
  const bool above = wanted_A > gains_.greatest_current_A;
  const bool below = wanted_A < gains_.least_current_A;
  if (!(above && error > 0) && !(below && error < 0)) {
    integral_A_ += gains_.integral_A_s * error * dt_s;
  }
  return std::clamp(wanted_A, gains_.least_current_A, gains_.greatest_current_A);
}

std::vector<LoopRow> position_loop(Family family, const StrainResistance<double>::Params& estimator,
                                   int goals, std::uint64_t seed) {
  constexpr int every = 20;
  constexpr double each_s = 22;
  Bench bench(family, estimator);
  const PidGains limits = gains();
  bench.step_for(3, limits.greatest_current_A);
  bench.step_for(4, limits.least_current_A);
  PidController controller(limits);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> position(0.012, 0.032);
  std::vector<LoopRow> rows;
  long tick = 0;
  for (int i = 0; i < goals; ++i) {
    const double goal = position(random);
    for (const long stop = tick + std::lround(each_s / step_s); tick < stop; ++tick) {
      const double current_A = controller.current_A(goal, bench.estimate(), step_s);
      if (tick % every == 0) {
        rows.push_back({static_cast<double>(tick) * step_s, goal, bench.strain(), bench.estimate(),
                        current_A, bench.stress_Pa()});
      }
      bench.step(current_A);
    }
  }
  return rows;
}

}  // namespace smaservo::bench_002
