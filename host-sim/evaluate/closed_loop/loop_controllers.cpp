#include "host-sim/evaluate/closed_loop/loop_controllers.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "host-sim/evaluate/runs/calibrate.hpp"
#include "host-sim/evaluate/runs/runs.hpp"
#include "host-sim/papers/fits/strain_resistance_fit.hpp"
#include "observer/line.hpp"
#include "observer/papers/position_pid.hpp"

namespace smaservo::evaluate {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Command<double> to_strain(double goal) {
  return {.fresh = true, .arm = true, .mode = Mode::strain, .setpoint = goal};
}

class StrainLoop final : public LoopController {
 public:
  StrainLoop(const Wire<double>& wire, bool ideal) : device_(loop_settings(wire)), ideal_(ideal) {}
  double current_A(const Inputs<double>& in, double goal, double true_strain) override {
    return device_.step(in, to_strain(goal), ideal_ ? true_strain : nan).drive_current_A;
  }
  Fault tripped() const override { return device_.output().first_cause; }

 private:
  DeviceLoop device_;
  bool ideal_;
};

class ResistanceLoop final : public LoopController {
 public:
  explicit ResistanceLoop(const Wire<double>& wire)
      : device_(loop_settings(wire)),
        line_{plant_params(wire)},
        area_m2_(wire.geometry.area_m2()) {}
  double current_A(const Inputs<double>& in, double goal, double /*true_strain*/) override {
    using Line = LineObserver<double>;
    const double air_K = room_K;
    const Line::State at{air_K, in.sample.load_N / area_m2_, 0};
    const Command<double> command{.fresh = true,
                                  .arm = true,
                                  .mode = Mode::resistance,
                                  .setpoint = Line::resistance_ohm(line_, at, goal)};
    return device_.step(in, command, nan).drive_current_A;
  }
  Fault tripped() const override { return device_.output().first_cause; }

 private:
  DeviceLoop device_;
  LineObserver<double>::Params line_;
  double area_m2_;
};

class PositionLoop final : public LoopController {
 public:
  using Observer = papers::StrainResistance<double>;

  explicit PositionLoop(const KnownUnit& known)
      : params_(known.estimator_002),
        controller_(papers::PidGains{40, 20, 0.4, loop_settings(known.wire).limits.min_current_A,
                                     loop_settings(known.wire).limits.current_A}),
        area_m2_(known.wire.geometry.area_m2()),
        min_A_(loop_settings(known.wire).limits.min_current_A) {}
  double current_A(const Inputs<double>& in, double goal, double /*true_strain*/) override {
    if (in.sample.current_A < 0.5 * min_A_) {
      return min_A_;
    }
    const Measurement<double> m{in.sample.voltage_V / in.sample.current_A,
                                0,
                                0,
                                in.sample.load_N / area_m2_,
                                true,
                                false,
                                true};
    if (!started_) {
      state_ = Observer::start(params_, m, room_K);
      started_ = true;
    }
    Observer::advance(params_, state_, m, LoopBench::step_s);
    return controller_.current_A(goal, Observer::estimate(params_, state_).strain,
                                 LoopBench::step_s);
  }

 private:
  Observer::Params params_;
  Observer::State state_{};
  bool started_ = false;
  papers::PidController controller_;
  double area_m2_, min_A_;
};

}  // namespace

std::string_view loop_kind_name(LoopKind kind) {
  switch (kind) {
    case LoopKind::device:
      return "device";
    case LoopKind::ideal:
      return "ideal sensor";
    case LoopKind::resistance:
      return "resistance";
    case LoopKind::position_002:
      break;
  }
  return "002";
}

DeviceLoop::DeviceLoop(const Settings<double>& settings)
    : prepared_(prepare(settings)), state_(Device<double>::start()) {}

const Output<double>& DeviceLoop::step(const Inputs<double>& in, const Command<double>& command,
                                       double true_strain) {
  using D = Device<double>;
  const Measurement<double> m = D::observe(prepared_, state_, in, LoopBench::step_s);
  Estimate<double> e = D::estimate(prepared_, state_);
  e.strain = std::isnan(true_strain) ? e.strain : true_strain;
  output_ = D::decide(prepared_, state_, in, m, e, command, LoopBench::step_s);
  return output_;
}

KnownUnit known_unit(hal::Family family, std::uint64_t seed, const std::string& folder) {
  KnownUnit known{bench::random_unit(family, seed), {}, {}};
  known.wire = calibrated_wire(known.unit, folder);
  std::vector<identify::Run> runs;
  for (std::size_t i = 0; i < calibration_stresses_MPa.size(); ++i) {
    // The estimator's lines cannot represent light loads, at which much R-phase forms.
    if (calibration_stresses_MPa.at(i) >= 50) {
      runs.push_back(calibration_measurement(known.unit, i));
    }
  }
  known.estimator_002 = fits::identify_strain_resistance(runs).params;
  return known;
}

std::unique_ptr<LoopController> make_loop(LoopKind kind, const KnownUnit& known) {
  switch (kind) {
    case LoopKind::device:
      return std::make_unique<StrainLoop>(known.wire, false);
    case LoopKind::ideal:
      return std::make_unique<StrainLoop>(known.wire, true);
    case LoopKind::resistance:
      return std::make_unique<ResistanceLoop>(known.wire);
    case LoopKind::position_002:
      break;
  }
  return std::make_unique<PositionLoop>(known);
}

}  // namespace smaservo::evaluate
