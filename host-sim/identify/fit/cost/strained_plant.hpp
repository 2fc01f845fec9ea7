#pragma once
// The plants of balanced_plant.hpp for a wire whose strain is given, by a test frame or a stop: the
// stress of each step is the one at which the wire has this strain.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "host-sim/identify/fit/cost/balanced_plant.hpp"

namespace smaservo::identify {

/// What acts on a wire between clamps during one step.
template <class T>
struct StrainedInput {
  T power_W;
  T strain;  ///< at the end of the step
  T ambient_K;
};

/// The end of a step of the plain plant.
struct StrainedStep {
  double temperature_K;
  double stress_Pa;
  bool bounded;  ///< no stress in its range gives the strain; it is the nearest one
};

/// The stress in 0 to `most_stress_Pa` at which a strain that rises with stress has a value:
/// `excess(stress_Pa)` is the strain less that value; it counts as too long if it is not a number.
/// `compliance_1_Pa`: a guess of its slope, in whose place the slope at the solution is put. At
/// most 40 calls; the last one is of the stress that is returned.
template <class Excess>
double stress_of(double guess_Pa, double most_stress_Pa, double& compliance_1_Pa,
                 const Excess& excess) {
  constexpr double exact = 1e-10;
  constexpr int most_calls = 40;
  double low = 0, high = most_stress_Pa;
  double at = std::clamp(guess_Pa, low, high);
  double last = 0, last_excess = 0;
  for (int call = 0; call < most_calls; ++call) {
    const double here = excess(at);
    const double slope = (here - last_excess) / (at - last);
    if (call > 0 && slope > 0) {
      compliance_1_Pa = slope;
    }
    const bool at_the_end = (at <= 0 && !(here < 0)) || (at >= most_stress_Pa && here < 0);
    if (std::abs(here) < exact || at_the_end || high - low < 1) {
      return at;
    }
    (here < 0 ? low : high) = at;
    last = at;
    last_excess = here;
    const double secant = at - here / compliance_1_Pa;
    // The secant may stay at one side; every fourth step halves the range that is left.
    at = low < secant && secant < high && call % 4 != 3              ? secant
         : secant <= 0 && low <= 0 && call % 4 != 3                  ? 0
         : secant >= high && high >= most_stress_Pa && call % 4 != 3 ? high
                                                                     : 0.5 * (low + high);
  }
  return last;
}

/// The plant without derivatives.
class StrainedPlant {
 public:
  using Params = BalancedPlant::Params;

  /// The wire rests at this temperature, where it was cooled to under the stress that gives it this
  /// strain. No stress becomes greater than `most_stress_Pa`.
  StrainedPlant(const Params& params, double most_stress_Pa, double ambient_K, double strain)
      : params_(params), most_stress_Pa_(most_stress_Pa), plant_(params, {ambient_K, 0}) {
    stress_Pa_ = stress_of(0, most_stress_Pa_, compliance_1_Pa_, [&](double stress_Pa) {
      plant_ = BalancedPlant(params_, {ambient_K, stress_Pa});
      return excess(strain);
    });
  }

  void advance(const StrainedInput<double>& in, double dt_s) {
    const BalancedPlant before = plant_;
    stress_Pa_ = stress_of(stress_Pa_, most_stress_Pa_, compliance_1_Pa_, [&](double stress_Pa) {
      plant_ = before;
      plant_.advance({in.power_W, stress_Pa, in.ambient_K}, dt_s);
      return excess(in.strain);
    });
  }

  double stress_Pa() const { return stress_Pa_; }
  StrainedStep step() const {
    return {plant_.temperature_K(), stress_Pa_, stress_Pa_ <= 0 || stress_Pa_ >= most_stress_Pa_};
  }

 private:
  double excess(double strain) const {
    return Plant<BalancedPlant::K>::strain(params_, {plant_.state(), 0}) - strain;
  }

  Params params_;
  double most_stress_Pa_;
  BalancedPlant plant_;
  double stress_Pa_ = 0;
  double compliance_1_Pa_ = 1 / 40e9;
};

/// The plant on the same path, with derivatives. Temperatures and stresses are those of the plain
/// plant; their derivatives follow from the balances of heat and strain.
template <class T>
class FollowingStrainedPlant {
 public:
  using K = ThreePhase<T>;
  using Params = typename Plant<K>::Params;

  /// `at_rest` is the plain plant before its first step.
  FollowingStrainedPlant(const Params& params, const T& ambient_K, const StrainedStep& at_rest,
                         const T& strain)
      : params_(params),
        state_(K::rest(params.kinetics, {ambient_K, seeded(at_rest.stress_Pa)})),
        heat_J_(T(0)) {
    if constexpr (!std::is_floating_point_v<T>) {
      const T missing = strain - Plant<K>::strain(params_, {state_, T(0)});
      const double slope = -missing.v[jet_temperature];
      T change = at_rest.bounded ? T(0) : missing / T(slope);
      change.v[jet_temperature] = 0;
      for_each_number<T>(state_, state_,
                         [&](T& x, const T& /*same*/) { follow(x, change, T(0), 0); });
    }
  }

  const typename K::State& state() const { return state_; }
  const T& stress_Pa() const { return state_.drive.stress_Pa; }

  /// `plain` is the same step of the plain plant.
  void advance(const StrainedStep& plain, const StrainedInput<T>& in, double dt_s) {
    const ThermalBody<T>& body = params_.body;
    const T before_K = K::drive(state_).temperature_K;
    const T above = before_K - in.ambient_K;
    const T heat_J = heat_J_ + (in.power_W - body.loss_W(above)) * T(dt_s);
    const T plain_J_K = body.capacity_J_K + T(0.5) * body.loss_slope_W_K(above) * T(dt_s);
    const Phases<T> z = K::phases(state_);
    const auto heat_left_J = [&](const typename K::State& s) {
      const Phases<T> now = K::phases(s);
      return heat_J - plain_J_K * (K::drive(s).temperature_K - before_K) +
             body.latent_m2a_J * (now.martensite - z.martensite) +
             body.latent_r2a_J * (now.r_phase - z.r_phase);
    };
    if constexpr (std::is_floating_point_v<T>) {
      K::advance(params_.kinetics, state_, {plain.temperature_K, plain.stress_Pa});
    } else {
      // Both balances are 0 at the plain temperature T' and stress σ'. A change of the parameters
      // changes them by dF and dG, and moves T' and σ' by what balances that. The same step is made
      // twice, for the derivatives by T' and for those by σ'.
      typename K::State by_stress = state_;
      K::advance(params_.kinetics, state_, {seeded(plain.temperature_K), T(plain.stress_Pa)});
      K::advance(params_.kinetics, by_stress, {T(plain.temperature_K), seeded(plain.stress_Pa)});
      const auto strain_left = [&](const typename K::State& s) {
        return Plant<K>::strain(params_, {s, T(0)}) - in.strain;
      };
      const T dF = heat_left_J(state_);
      const T dG = strain_left(state_);
      const double F_T = dF.v[jet_temperature];
      const double G_T = dG.v[jet_temperature];
      const double F_s = heat_left_J(by_stress).v[jet_temperature];
      const double G_s = strain_left(by_stress).v[jet_temperature];
      const double det = F_T * G_s - F_s * G_T;
      T change_K = plain.bounded ? dF / T(-F_T) : (dF * T(G_s) - dG * T(F_s)) / T(-det);
      T change_Pa = plain.bounded ? T(0) : (dG * T(F_T) - dF * T(G_T)) / T(-det);
      change_K.v[jet_temperature] = change_Pa.v[jet_temperature] = 0;
      for_each_number<T>(state_, by_stress, [&](T& x, const T& same) {
        follow(x, change_K, change_Pa, same.v[jet_temperature]);
      });
    }
    heat_J_ = heat_left_J(state_);
  }

 private:
  static T seeded(double value) {
    if constexpr (std::is_floating_point_v<T>) {
      return value;
    } else {
      return T(value, jet_temperature);
    }
  }
  /// Replaces the derivative by what was seeded by those of the changes.
  static void follow(T& x, const T& change, const T& other, double by_other) {
    const double by_change = x.v[jet_temperature];
    x.v[jet_temperature] = 0;
    for (int i = 0; i < jet_width; ++i) {
      x.v[i] += by_change * change.v[i] + by_other * other.v[i];
    }
  }

  Params params_;
  typename K::State state_;
  T heat_J_;
};

}  // namespace smaservo::identify
