#pragma once
// The lumped plant for a fit: the energy balance of each step is solved, not linearised. The
// linearised step with its carried heat has correct values, but the errors of their derivatives by
// the parameters would grow from step to step where the transformation curve bends.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "host-sim/identify/fit/jet_fraction.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::identify {

/// The plant without derivatives. It is of second order in the step, since it uses the mean of the
/// losses at both ends of the step. Steps may be some hundredths of the wire's time constant.
class BalancedPlant {
 public:
  using K = ThreePhase<double>;
  using Params = Plant<K>::Params;

  BalancedPlant(const Params& params, const Drive<double>& start)
      : params_(params), state_(K::rest(params.kinetics, start)) {}

  const K::State& state() const { return state_; }
  double temperature_K() const { return K::drive(state_).temperature_K; }
  Phases<double> phases() const { return K::phases(state_); }
  /// Derivative of the last step's heat balance by the temperature at its end: heat capacity,
  /// latent heat, and half the slope of the loss times the step.
  double capacity_J_K() const { return capacity_J_K_; }

  void advance(const PlantInput<double>& in, double dt_s) {
    const ThermalBody<double>& body = params_.body;
    const double T = temperature_K();
    const double above = T - in.ambient_K;
    const double heat_J = heat_J_ + (in.power_W - body.loss_W(above)) * dt_s;
    const double plain_J_K = body.capacity_J_K + 0.5 * body.loss_slope_W_K(above) * dt_s;
    const Heading heading = heat_J > 0 ? Heading::heating : Heading::cooling;
    // Latent heat only slows the change: the step ends between the present temperature and the one
    // that it would reach without latent heat.
    double low = std::min(0.0, heat_J / plain_J_K);
    double high = std::max(0.0, heat_J / plain_J_K);
    double dT = heat_J / (body.effective_capacity_J_K(K::rates(params_.kinetics, state_, heading)) +
                          plain_J_K - body.capacity_J_K);
    const K::State before = state_;
    const Phases<double> z = K::phases(before);
    for (int i = 0; i < max_iterations; ++i) {
      state_ = before;
      K::advance(params_.kinetics, state_, {T + dT, in.stress_Pa});
      const Phases<double> after = K::phases(state_);
      heat_J_ = heat_J - plain_J_K * dT + body.latent_m2a_J * (after.martensite - z.martensite) +
                body.latent_r2a_J * (after.r_phase - z.r_phase);
      const bool moved = after.martensite != z.martensite || after.r_phase != z.r_phase;
      const PhaseRates<double> rates =
          moved ? K::rates(params_.kinetics, state_, state_.heading) : PhaseRates<double>{0, 0};
      capacity_J_K_ = body.effective_capacity_J_K(rates) + plain_J_K - body.capacity_J_K;
      if (std::abs(heat_J_) < 1e-5 * plain_J_K) {
        break;
      }
      (heat_J_ > 0 ? low : high) = dT;
      const double newton = dT + heat_J_ / capacity_J_K_;
      dT = low < newton && newton < high ? newton : 0.5 * (low + high);
    }
  }

 private:
  static constexpr int max_iterations = 12;

  Params params_;
  K::State state_;
  double heat_J_ = 0;  ///< remaining error of the heat balance after the last step
  double capacity_J_K_ = 0;
};

/// The end of a step of the plain plant.
struct BalancedStep {
  double temperature_K;
  double capacity_J_K;  ///< BalancedPlant::capacity_J_K()
};

/// Calls `change` with each number of a state that depends on where the last step went, and with
/// the same number of another state. Of the turning points this can only be the newest.
template <class T, class Change>
void for_each_number(typename ThreePhase<T>::State& state,
                     const typename ThreePhase<T>::State& other, Change change) {
  const auto both = [&](Pair<T>& pair, const Pair<T>& same) {
    T first = pair.first();
    T second = pair.second();
    change(first, same.first());
    change(second, same.second());
    pair = Pair<T>(first, second);
  };
  change(state.drive.temperature_K, other.drive.temperature_K);
  change(state.drive.stress_Pa, other.drive.stress_Pa);
  change(state.reached.temperature_K, other.reached.temperature_K);
  change(state.reached.stress_Pa, other.reached.stress_Pa);
  change(state.martensite, other.martensite);
  change(state.r_phase, other.r_phase);
  change(state.returning, other.returning);
  change(state.reverse.m2a, other.reverse.m2a);
  change(state.reverse.r2a, other.reverse.r2a);
  change(state.forward.r2m, other.forward.r2m);
  both(state.forward.a2m_a2r, other.forward.a2m_a2r);
  auto& hot = state.hot.newest();
  const auto& other_hot = other.hot.newest();
  change(hot.left.m2a, other_hot.left.m2a);
  change(hot.left.r2a, other_hot.left.r2a);
  change(hot.martensite, other_hot.martensite);
  change(hot.r_phase, other_hot.r_phase);
  auto& cold = state.cold.newest();
  const auto& other_cold = other.cold.newest();
  both(cold.left.a2m_a2r, other_cold.left.a2m_a2r);
  change(cold.left.r2m, other_cold.left.r2m);
  change(cold.austenite, other_cold.austenite);
  change(cold.r_phase, other_cold.r_phase);
  change(cold.returning, other_cold.returning);
}

/// The plant on the same path, with derivatives. The temperatures are those of the plain plant;
/// their derivatives follow from the balance.
template <class T>
class FollowingPlant {
 public:
  using K = ThreePhase<T>;
  using Params = typename Plant<K>::Params;

  FollowingPlant(const Params& params, const Drive<T>& start)
      : params_(params), state_(K::rest(params.kinetics, start)), heat_J_(T(0)) {}

  const typename K::State& state() const { return state_; }

  /// Moves the kinetics to a known temperature.
  void move(const Drive<T>& drive) { K::advance(params_.kinetics, state_, drive); }

  /// `plain` is the same step of the plain plant.
  void advance(const BalancedStep& plain, const PlantInput<T>& in, double dt_s) {
    if constexpr (std::is_floating_point_v<T>) {
      move({plain.temperature_K, in.stress_Pa});
    } else {
      const ThermalBody<T>& body = params_.body;
      const T before_K = K::drive(state_).temperature_K;
      const T above = before_K - in.ambient_K;
      const T heat_J = heat_J_ + (in.power_W - body.loss_W(above)) * T(dt_s);
      const T plain_J_K = body.capacity_J_K + T(0.5) * body.loss_slope_W_K(above) * T(dt_s);
      const Phases<T> z = K::phases(state_);
      // F(T') = 0 at the plain temperature T'; a change dF due to the parameters moves T' by
      // -dF/F'. The derivatives by T' have an index of their own. When those of T' are known, both
      // are multiplied and added, so that the step is made only once.
      move({T(plain.temperature_K, jet_temperature), in.stress_Pa});
      const Phases<T> there = K::phases(state_);
      const T missing_J = heat_J - plain_J_K * (T(plain.temperature_K) - before_K) +
                          body.latent_m2a_J * (there.martensite - z.martensite) +
                          body.latent_r2a_J * (there.r_phase - z.r_phase);
      T goal_K = missing_J / T(plain.capacity_J_K);
      goal_K.a = plain.temperature_K;
      goal_K.v[jet_temperature] = 0;
      for_each_number<T>(state_, state_, [&](T& x, const T& /*same*/) {
        const double by_temperature = x.v[jet_temperature];
        x.v[jet_temperature] = 0;
        for (int i = 0; i < jet_width; ++i) {
          x.v[i] += by_temperature * goal_K.v[i];
        }
      });
      const Phases<T> now = K::phases(state_);
      heat_J_ = heat_J - plain_J_K * (goal_K - before_K) +
                body.latent_m2a_J * (now.martensite - z.martensite) +
                body.latent_r2a_J * (now.r_phase - z.r_phase);
    }
  }

 private:
  Params params_;
  typename K::State state_;
  T heat_J_;
};

}  // namespace smaservo::identify
