// The plants on which relay tests are run.

#include <algorithm>
#include <cmath>
#include <memory>

#include "hal/sim/simulated_wire.hpp"
#include "host-sim/tune/relay/relay.hpp"

namespace smaservo::tune {
namespace {

constexpr double period_ticks = 20;  ///< aimed period of the oscillation
constexpr double test_share = 0.05;  ///< share of the stroke that the wire moves during a test

double variable(LoopName name, double temperature_K, double strain, double ohm, double load_N) {
  switch (name) {
    case LoopName::temperature:
      return temperature_K;
    case LoopName::resistance:
      return ohm;
    case LoopName::force:
      return load_N;
    case LoopName::strain:
      break;
  }
  return strain;
}

double variable_1_K(LoopName name, const OperatingPoint& p) {
  return variable(name, 1, p.strain_1_K, p.ohm_1_K, p.load_N_K);
}

/// The loop's linearisation at its point, from power to the variable.
LinearLoop linear(LoopName name, const OperatingPoint& p, double period_s) {
  return {period_s, 1, p.capacity_J_K, p.loss_slope_W_K, std::abs(variable_1_K(name, p)), 0, 0,
          1,        {}};
}

RelayTask relay_task(LoopName name, const OperatingPoint& p, const Branches& b, double period_s) {
  const double seconds = 8 * period_ticks * period_s;
  const double warms_K = std::abs(test_share * b.stroke() / p.strain_1_K);
  const double wanted_W = p.capacity_J_K * warms_K / seconds;
  const bool heats = p.motion == Motion::heating;
  const double heat_W = heats ? wanted_W : -std::min(wanted_W, 0.5 * p.loss_W);
  const double rate = variable_1_K(name, p) / p.capacity_J_K;
  RelayTask t{period_s,
              1,
              p.loss_W + heat_W,
              heat_W * p.loss_slope_W_K / p.capacity_J_K,
              0.7 * std::abs(heat_W),
              heat_W * rate,
              1,
              0};
  t.direction = rate < 0 ? -1 : 1;
  // A triangle wave rises from one end to the other in half a period; 1.5 sample periods are delay.
  t.hysteresis = t.amplitude_W * std::abs(rate) * (0.25 * period_ticks - 1.5) * period_s;
  return t;
}

/// The lumped, nonlinear model of the file's wire, starting in the state of the operating point.
RelayPlant lumped_plant(LoopName name, const TunedPlant& plant, const OperatingPoint& p,
                        double rest_strain, double period_s) {
  struct Body {
    LumpedModel::Params params;
    LumpedModel::State state;
  };
  auto body = std::make_shared<Body>(Body{lumped_params(plant), p.state});
  const auto read = [=] {
    const double stress_Pa = ThreePhase<double>::drive(body->state.kinetics).stress_Pa;
    return variable(name, LumpedModel::temperature_K(body->state),
                    LumpedModel::strain(body->params, body->state),
                    LumpedModel::resistance_ohm(body->params, body->state, plant.ambient_K),
                    stress_Pa * plant.wire.geometry.area_m2());
  };
  const auto advance = [=](double power_W) {
    advance_loaded(plant, body->params, body->state, power_W, rest_strain, period_s);
    return read();
  };
  return {advance, read()};
}

/// A wire of 24 segments under a constant load.
class SegmentedWire {
 public:
  SegmentedWire(const TunedPlant& plant, double period_s)
      : plant_(plant), period_s_(period_s), wire_(at_rest(plant)), rest_strain_(wire_->strain()) {}

  double advance(double power_W) {
    const double current_A = std::sqrt(std::max(0.0, power_W) / wire_->resistance_ohm());
    wire_->advance(current_A, {plant_.load.low_Pa, plant_.ambient_K, plant_.draught}, period_s_);
    return wire_->strain();
  }
  double shorter() const { return rest_strain_ - wire_->strain(); }
  double strain() const { return wire_->strain(); }

 private:
  static std::unique_ptr<hal::SimulatedWire> at_rest(const TunedPlant& plant) {
    std::mt19937_64 random(1);
    auto wire = hal::make_simulated_wire(hal::Family::ihyp, plant.wire, {}, 0.3, random);
    wire->rest(plant.ambient_K, plant.load.low_Pa);
    return wire;
  }

  TunedPlant plant_;
  double period_s_;
  std::unique_ptr<hal::SimulatedWire> wire_;
  double rest_strain_;
};

constexpr double longest_test_s = 120;

/// Drives the wire until it is this much shorter than at rest, on the way up or down. False if it
/// does not get there in time.
bool drive_to(SegmentedWire& wire, double power_W, double shorter, bool heats, double period_s) {
  for (double t = 0; t < longest_test_s; t += period_s) {
    if ((shorter <= wire.shorter()) == heats) {
      return true;
    }
    wire.advance(power_W);
  }
  return false;
}

/// Tests the loop of the strain on the segmented wire, half way on a branch. The wire is driven
/// there faster than in the test; then its rate at the test's power is measured.
RelayCheck segmented_check(const TunedPlant& plant, const Branches& b, const OperatingPoint& p,
                           double period_s) {
  RelayTask t = relay_task(LoopName::strain, p, b, period_s);
  RelayCheck check{LoopName::strain, p.motion, "24 segments", {}, {}};
  check.expected = expected_oscillation(linear(LoopName::strain, p, period_s), t);
  auto wire = std::make_shared<SegmentedWire>(plant, period_s);
  const bool heats = p.motion == Motion::heating;
  bool there = true;
  if (!heats) {
    const double fast_W = 2 * lumped_params(plant).body.loss_W(b.hottest_K - plant.ambient_K);
    there = drive_to(*wire, fast_W, 0.97 * b.stroke(), true, period_s);
  }
  const double before = p.share + (heats ? -0.03 : 0.03);
  const double fast_W = p.loss_W + (heats ? 3 : 1.8) * (t.base_W - p.loss_W);
  if (!there || !drive_to(*wire, fast_W, before * b.stroke(), heats, period_s)) {
    return check;
  }
  constexpr int watched = 20;
  double from = wire->strain();
  for (int i = 0; i < watched; ++i) {
    from = i == watched / 2 ? wire->strain() : from;
    wire->advance(t.base_W);
    t.base_W += t.base_rises_W_s * period_s;
  }
  t.rises_1_s = (wire->strain() - from) / (0.5 * watched * period_s);
  check.tested =
      relay_test(t, {[wire](double power_W) { return wire->advance(power_W); }, wire->strain()});
  return check;
}

/// The stop of a branch that is nearest to half of the stroke.
const OperatingPoint& middle(const Branches& b, Motion motion) {
  return *std::ranges::min_element(b.points, {}, [&](const OperatingPoint& p) {
    return std::abs(p.share - 0.5) + (p.motion == motion ? 0 : 1);
  });
}

}  // namespace

std::vector<RelayCheck> relay_checks(const TuneTask& task, const Proposal& p) {
  const double period_s = p.settings.timing.period_s;
  std::vector<RelayCheck> all;
  for (const Motion motion : {Motion::heating, Motion::cooling}) {
    const OperatingPoint& at = middle(p.branches, motion);
    for (const DesignedLoop& loop : p.loops) {
      if (!loop.possible) {
        continue;
      }
      const RelayTask t = relay_task(loop.name, at, p.branches, period_s);
      all.push_back(
          {loop.name, motion, "one body",
           relay_test(t, lumped_plant(loop.name, task.plant, at, p.branches.rest_strain, period_s)),
           expected_oscillation(linear(loop.name, at, period_s), t)});
    }
    const double test_s = 8 * period_ticks * period_s;
    if (!task.plant.load.is_spring() && test_s < p.branches.cooling_s) {
      all.push_back(segmented_check(task.plant, p.branches, at, period_s));
    }
  }
  return all;
}

}  // namespace smaservo::tune
