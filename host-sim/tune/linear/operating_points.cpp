#include "host-sim/tune/linear/operating_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/tune/linear/balance.hpp"

namespace smaservo::tune {
namespace {

using Kinetics3 = ThreePhase<double>;

constexpr double step_K = 0.02;
constexpr double overheat_K = 12;

/// A wire whose temperature is set and whose load follows its strain.
class Sweep {
 public:
  explicit Sweep(const TunedPlant& plant)
      : plant_(plant),
        params_(lumped_params(plant)),
        state_(LumpedModel::rest(params_, {plant.ambient_K, plant.load.low_Pa})),
        rest_strain_(strain()),
        area_m2_(plant.wire.geometry.area_m2()) {}

  void move(double dT) {
    const double to_K = temperature_K() + dT;
    const double stress_Pa = balanced_stress_Pa(plant_.load, this->stress_Pa(), [&](double at_Pa) {
      LumpedModel::State moved = state_;
      Kinetics3::advance(params_.kinetics, moved.kinetics, {to_K, at_Pa});
      return rest_strain_ - LumpedModel::strain(params_, moved);
    });
    Kinetics3::advance(params_.kinetics, state_.kinetics, {to_K, stress_Pa});
  }

  double temperature_K() const { return LumpedModel::temperature_K(state_); }
  double strain() const { return LumpedModel::strain(params_, state_); }
  double stress_Pa() const { return Kinetics3::drive(state_.kinetics).stress_Pa; }
  double finish_K() const {
    const Isobar<double> m2a = isobar(params_.kinetics.m2a, stress_Pa());
    return m2a.start_K + 1 / m2a.per_K;
  }

  /// Linearises by a central difference over two steps of the sweep, which move the wire on.
  OperatingPoint point(Motion motion, double dT, double share) {
    const Values before = values();
    move(dT);
    OperatingPoint p = here(motion, share);
    move(dT);
    const Values after = values();
    const double per_K = 1 / (after.temperature_K - before.temperature_K);
    p.capacity_J_K = (after.heat_J - before.heat_J) * per_K;
    p.strain_1_K = (after.strain - before.strain) * per_K;
    p.ohm_1_K = (after.ohm - before.ohm) * per_K;
    p.load_N_K = (after.stress_Pa - before.stress_Pa) * area_m2_ * per_K;
    return p;
  }

  /// Heat content with an arbitrary zero.
  double heat_J() const {
    const Phases<double> z = LumpedModel::phases(state_);
    return params_.body.capacity_J_K * temperature_K() - params_.body.latent_m2a_J * z.martensite -
           params_.body.latent_r2a_J * z.r_phase;
  }
  double ohm() const { return LumpedModel::resistance_ohm(params_, state_, plant_.ambient_K); }
  double loss_W() const { return params_.body.loss_W(temperature_K() - plant_.ambient_K); }

 private:
  struct Values {
    double temperature_K, heat_J, strain, ohm, stress_Pa;
  };
  Values values() const { return {temperature_K(), heat_J(), strain(), ohm(), stress_Pa()}; }

  OperatingPoint here(Motion motion, double share) const {
    return {motion,
            share,
            state_,
            stress_Pa(),
            strain(),
            ohm(),
            temperature_K(),
            params_.body.capacity_J_K,
            loss_W(),
            params_.body.loss_slope_W_K(temperature_K() - plant_.ambient_K),
            0,
            0,
            0};
  }

  TunedPlant plant_;
  LumpedModel::Params params_;
  LumpedModel::State state_;
  double rest_strain_;
  double area_m2_;
};

/// Sweeps the full cycle to find its ends, then again for the stops at shares of the stroke.
class Tracing {
 public:
  Tracing(const TunedPlant& plant, double max_K, int stops) : plant_(plant), stops_(stops) {
    Sweep sweep(plant);
    b_.rest_strain = sweep.strain();
    b_.heat_J = -sweep.heat_J();
    b_.min_ohm = b_.max_ohm = sweep.ohm();
    while (sweep.temperature_K() < std::min(sweep.finish_K() + overheat_K, max_K)) {
      sweep.move(step_K);
      take_ohm(sweep);
    }
    b_.hot_strain = sweep.strain();
    b_.hottest_K = sweep.temperature_K();
    b_.hot_Pa = sweep.stress_Pa();
    b_.heat_J += sweep.heat_J();
    cool(sweep);
  }

  Branches all() {
    Sweep heating(plant_);
    stop(heating, Motion::heating, step_K);
    stop(heating, Motion::cooling, -step_K);
    for (const double at : {0.25, 0.5, 0.75}) {
      turned(at);
    }
    return b_;
  }

 private:
  double share(double strain) const { return (b_.rest_strain - strain) / b_.stroke(); }

  void take_ohm(const Sweep& sweep) {
    b_.min_ohm = std::min(b_.min_ohm, sweep.ohm());
    b_.max_ohm = std::max(b_.max_ohm, sweep.ohm());
  }

  void cool(Sweep& sweep) {
    b_.cooling_s = 0;
    b_.fastest_cooling_1_s = 0;
    while (plant_.ambient_K + 1 < sweep.temperature_K()) {
      const double heat_J = sweep.heat_J();
      const double strain = sweep.strain();
      const double loss_W = sweep.loss_W();
      sweep.move(-step_K);
      take_ohm(sweep);
      const double took_s = (heat_J - sweep.heat_J()) / loss_W;
      b_.fastest_cooling_1_s = std::max(b_.fastest_cooling_1_s, (sweep.strain() - strain) / took_s);
      const double now = share(sweep.strain());
      b_.cooling_s += 0.1 < now && now < 0.9 ? took_s : 0;
    }
  }

  /// Sweeps a branch to its end and adds its stops on the way.
  void stop(Sweep& sweep, Motion motion, double dT) {
    const bool heating = motion == Motion::heating;
    const auto ended = [&] {
      return heating ? b_.hottest_K <= sweep.temperature_K()
                     : sweep.temperature_K() < plant_.ambient_K + 1;
    };
    for (int i = 1; i <= stops_; ++i) {
      const double at = static_cast<double>(heating ? i : stops_ + 1 - i) / (stops_ + 1);
      const auto there = [&] { return (at <= share(sweep.strain())) == heating; };
      while (!there() && !ended()) {
        sweep.move(dT);
      }
      if (ended()) {
        return;
      }
      b_.points.push_back(sweep.point(motion, dT, at));
    }
    while (!ended()) {
      sweep.move(dT);
    }
  }

  /// The temperature of the nearest stop; NaN if the branch has none near this share.
  double stop_K(Motion motion, double at) const {
    double best = 0.5 / stops_;
    double found_K = std::numeric_limits<double>::quiet_NaN();
    for (const OperatingPoint& p : b_.points) {
      if (p.motion == motion && std::abs(p.share - at) <= best) {
        best = std::abs(p.share - at);
        found_K = p.temperature_K;
      }
    }
    return found_K;
  }

  /// Adds the state half way between the branches: the wire is heated to this share, then cooled.
  void turned(double at) {
    const double middle_K = 0.5 * (stop_K(Motion::heating, at) + stop_K(Motion::cooling, at));
    if (std::isnan(middle_K)) {
      return;
    }
    Sweep sweep(plant_);
    while (share(sweep.strain()) < at) {
      sweep.move(step_K);
    }
    while (middle_K < sweep.temperature_K()) {
      sweep.move(-step_K);
    }
    b_.points.push_back(sweep.point(Motion::turned, -step_K, at));
  }

  TunedPlant plant_;
  int stops_;
  Branches b_{};
};

}  // namespace

LumpedModel::Params lumped_params(const TunedPlant& plant) {
  LumpedModel::Params params = plant_params(plant.wire);
  params.body.loss_W_K *= plant.draught;
  params.body.loss_W_K2 *= plant.draught;
  return params;
}

double advance_loaded(const TunedPlant& plant, const LumpedModel::Params& params,
                      LumpedModel::State& state, double power_W, double rest_strain, double dt_s) {
  // A step assumes a constant stress and carries the error into the next ones, so a spring needs
  // shorter steps.
  const int parts = plant.load.is_spring() ? 8 : 1;
  const double part_s = dt_s / parts;
  double stress_Pa = Kinetics3::drive(state.kinetics).stress_Pa;
  for (int i = 0; i < parts; ++i) {
    const auto advanced = [&](double at_Pa) {
      LumpedModel::State moved = state;
      LumpedModel::advance(params, moved, {power_W, at_Pa, plant.ambient_K}, part_s);
      return moved;
    };
    stress_Pa = balanced_stress_Pa(plant.load, stress_Pa, [&](double at_Pa) {
      return rest_strain - LumpedModel::strain(params, advanced(at_Pa));
    });
    state = advanced(stress_Pa);
  }
  return stress_Pa;
}

std::string motion_name(Motion motion) {
  switch (motion) {
    case Motion::heating:
      return "heating";
    case Motion::cooling:
      return "cooling";
    case Motion::turned:
      break;
  }
  return "turned";
}

Branches trace_branches(const TunedPlant& plant, double max_K, int stops) {
  return Tracing(plant, max_K, stops).all();
}

}  // namespace smaservo::tune
