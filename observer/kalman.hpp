#pragma once
// The three-phase model as a nonlinear observer: an extended Kalman filter that predicts with the
// wire's heat balance and kinetics and corrects by the resistance. observer/README.md says what
// was tried, and what the filter reaches.

#include <cmath>

#include "model/scalar/order.hpp"
#include "model/scalar/scalar.hpp"
#include "model/wire/plant.hpp"
#include "observer/covariance.hpp"
#include "observer/estimate.hpp"

namespace smaservo {

/// The filter's assumptions, made for a wire by kalman_tuning(). Values are standard deviations;
/// walks are per square root of a second.
template <class S>
struct KalmanTuning {
  /// Share of the temperature above ambient: its error in steady state by heat that the balance
  /// does not include.
  S heat_error = S(0.016);
  S fraction_noise = S(0.2);  ///< per square root of the converted fraction
  S ambient_walk_K = S(0.35);
  S loss_walk = S(0.0013);      ///< relative
  S resistance_walk = S(8e-6);  ///< relative
  /// Relative, for one sample at 1 kHz: the model's error is coloured, so it weighs far more than
  /// the sensor's noise.
  S resistance_model_sd = S(0.05);
  /// Relative: the bias of the innovation that the model's own error reaches.
  S resistance_bias = S(1.6e-3);
  S stress_filter_s = S(0.023);
  S start_temperature_sd_K = S(1);
  S start_fraction_sd = S(0.05);
  S start_ambient_sd_K = S(18);
  /// The heat loss is unknown but for loss_range. On the project's traces 0.3, a device's
  /// default, is as good: mean errors differ by 0.05 % of the stroke at most.
  S start_loss_sd = S(1.5);
  S start_resistance_sd = S(0.03);
  // The slow states stay within these ranges around their start: a filter that has wrong phases
  // would otherwise explain the resistance by its surroundings.
  S ambient_range_K = S(20);
  S loss_range = S(1.6);  ///< factor, upwards and downwards
  S resistance_range = S(0.025);
  /// Upper bound of the wire's temperature; the lower one is the coldest air.
  S hottest_K = S(550);
  // The estimate's variance is the filter's own times reported² plus strain_model_sd². The filter
  // works best when it overestimates its variance; reported < 1 corrects this in the estimate.
  // strain_model_sd covers errors of the model that the filter does not know.
  S reported = S(0.33);
  S strain_model_sd = S(0.0003);
};

/// The tuning for a wire whose parameters have this accuracy.
template <class S>
constexpr KalmanTuning<S> kalman_tuning(const Accuracy<S>& accuracy) {
  KalmanTuning<S> tuning;
  tuning.fraction_noise = S(375) * accuracy.strain;
  tuning.start_fraction_sd = S(27) * accuracy.strain;
  tuning.strain_model_sd = S(0.4) * accuracy.strain;
  const S bias = S(1.5) * accuracy.resistance;
  tuning.resistance_bias = tuning.resistance_bias < bias ? bias : tuning.resistance_bias;
  return tuning;
}

/// The filter: observer/README.md has its equations. It is an observer (StrainObserver). All
/// functions are static; what changes is in State.
template <class S>
struct KalmanObserver : FilterStates {
  using Scalar = S;
  using Kinetics = ThreePhase<S>;
  using Model = Plant<Kinetics>;

  /// The wire and the tuning.
  struct Params {
    typename Model::Params model;
    KalmanTuning<S> tuning;
    /// Strain below which a hard stop does not let the wire contract, so that it pulls more than
    /// its load; 0 if there is none. Leave it 0 where the measured load is all that the wire pulls.
    S stop_strain = S(0);
  };

  using Vector = typename Covariance<S>::Vector;

  /// Mean and covariance of the estimate; trivially copyable.
  struct State {
    Covariance<S> covariance;
    typename Kinetics::State kinetics;
    PhaseRates<S> rates;  ///< rates of the kinetics after the last step
    S heat_J;  ///< heat error of the last step's linearisation, carried into the next step
    S ambient_K;
    S start_ambient_K;
    S loss;
    S loss_range;  ///< the loss stays between this and its reciprocal; wider after go_on()
    S resistance;
    S load_Pa;              ///< the load's stress, low-pass filtered
    S slow_load_Pa;         ///< the same, averaged over 0.5 s
    S stress_Pa;            ///< the wire's: the load's, and where it pulls at its stop more
    S model_ohm;            ///< resistance expected at the last measurement, before the correction
    S innovation_ohm;       ///< measured less expected resistance; 0 if there was no correction
    S innovation_variance;  ///< expected square of the innovation, ohm²
    S mismatch;             ///< relative magnitude of the innovation, averaged over 2 s
    S bias;                 ///< relative innovation with its sign, averaged over 0.1 s
    S noise;                ///< relative standard deviation of the sensors, averaged alike
    S unproven;             ///< 1 after go_on(); a seventh after a whole transformation
  };

  /// A wire that was cooled to the ambient temperature and rests there.
  static State start(const Params& p, const Measurement<S>& m, const S& ambient_K) {
    State s;
    start_at_rest(p, s, m, ambient_K, rest_slope(p, m.stress_Pa, ambient_K));
    return s;
  }
  /// The change of the phases at rest per kelvin of the ambient temperature. Cost: half of a start
  /// at rest.
  static PhaseRates<S> rest_slope(const Params& p, const S& stress_Pa, const S& ambient_K);
  /// The same in place, with rest_slope() computed before.
  static void start_at_rest(const Params& p, State& s, const Measurement<S>& m, const S& ambient_K,
                            const PhaseRates<S>& rest_slope);
  /// Starts from a guess of temperature and phases.
  static void start(const Params& p, State& s, const Measurement<S>& m, const S& ambient_K,
                    const S& temperature_K, const Phases<S>& phases, const S& fraction_sd,
                    const S& temperature_sd_K);
  /// Leads the kinetics to this temperature along their path, without heat balance or correction.
  static void lead(const Params& p, State& s, const S& temperature_K) {
    // Without the derivatives it would be a second copy of the code.
    Kinetics::advance_linearised(p.model.kinetics, s.kinetics, {temperature_K, s.stress_Pa});
  }
  /// Goes on from where lead() has ended: the air has moved, or stands still now, so that the wire
  /// has got there at this power. The loss is unknown; the phases belong to the temperature.
  static void go_on(const Params& p, State& s, const S& power_W, Heading heading);
  /// One step of dt_s, 0 to 5 ms: predicts with the power and stress of the measurement, then
  /// corrects with its resistance, where that is valid and the wire does not pull at its stop. Cost
  /// at the stop: a few predictions, at most 13.
  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s);
  /// The strain with its standard deviation, temperature, phases and health.
  static Estimate<S> estimate(const Params& p, const State& s);
  /// Whether the resistance differs from the model's by more than 1 %, averaged over 2 s.
  static bool contradicted(const State& s) { return S(0.01) < s.mismatch; }
  /// Whether the resistance has differed from the model's in one direction, for 0.1 s or so, by
  /// more than errors of the model, times this factor, and of the sensors explain. The model's
  /// error is larger while the load changes.
  static bool strayed(const Params& p, const State& s, const S& factor) {
    const S moving = S(1) + magnitude(s.load_Pa - s.slow_load_Pa) / S(30e6);
    return factor * moving * p.tuning.resistance_bias + S(3) * s.noise < magnitude(s.bias);
  }
  /// Whether the wire pulls at its stop. Its stress follows from strain and heat balance then: the
  /// resistance hardly shows the phases of a wire whose length is held.
  static bool held(const State& s) { return s.load_Pa < s.stress_Pa; }
  /// Logarithm of the likelihood of a measured resistance at the present mean, as in a step of
  /// dt_s, up to a constant that all filters share.
  static S log_likelihood(const Params& p, const State& s, const Measurement<S>& m, const S& dt_s) {
    const Expected expect = expected(p, s);
    const S y = m.resistance_ohm - expect.ohm;
    const Vector PH = s.covariance.times(expect.slope);
    return S(-0.5) * y * y / innovation_variance(p, expect, PH, m, dt_s);
  }
  /// The strain of the whole wire.
  static S whole_strain(const Params& p, const State& s) {
    return smaservo::strain(p.model.material, p.model.ends.average(Kinetics::phases(s.kinetics)),
                            s.stress_Pa);
  }

  // The parts of a step, public for tests of their derivatives.

  /// Derivatives of a prediction: those of the temperature by all states, and how the phases follow
  /// the temperature. With z' the rates after the step, d(phases after) = T (d(phases before) -
  /// z'_before d(temperature before)) + z' d(temperature after).
  struct Linear {
    Vector temperature;
    typename Kinetics::Tangent tangent;  ///< T and z'
    PhaseRates<S> moved;                 ///< T z'_before
    S noise_K2;                          ///< variance that the step adds to the temperature
    S converted_m, converted_r;          ///< magnitude of each phase's change
  };
  static Linear predict_mean(const Params& p, State& s, const S& power_W, const S& dt_s);

  /// The resistance that the model expects, and its derivatives by the states.
  struct Expected {
    S ohm;
    Vector slope;
  };
  /// At the state's present mean.
  static Expected expected(const Params& p, const State& s);

 private:
  // Out of line: the copies are not a part of each step's memory on the stack.
  [[gnu::noinline]] static Linear predict_at_stop(const Params& p, State& s, const S& power_W,
                                                  const S& dt_s, const S& before_Pa);

  // What go_on() assumes of the loss: it takes the wire further in the same direction, since it is
  // this factor beyond both the loss before and the one that would balance the power here. A loss
  // that takes it too far is corrected by the resistance; one that holds it back takes the wire off
  // its branch, where the resistance says little of the temperature.
  static constexpr S beyond_balance = S(1.5);
  static constexpr S moved_loss_range = S(3);
  static constexpr S moved_loss_sd = S(0.5);
  static constexpr S moved_temperature_sd_K = S(3);
  /// Deviation of the strain beyond the filter's own after go_on(): 2 % of a 4 % stroke.
  static constexpr S unproven_sd = S(8e-4);

  /// Adds the variance of an error that moves temperature, phases and ambient temperature together.
  static void add_along(Covariance<S>& P, const S (&along)[4], const S& variance);
  static void predict_covariance(const Params& p, Covariance<S>& P, const Linear& f, const S& dt_s);
  static void keep_on_simplex(const Covariance<S>& P, const Phases<S>& z, Vector& change);
  static S innovation_variance(const Params& p, const Expected& expect, const Vector& PH,
                               const Measurement<S>& m, const S& dt_s);
  static void correct(const Params& p, State& s, const Measurement<S>& m, const Linear& f,
                      const Expected& expect, const S& dt_s);
};

template <class S>
PhaseRates<S> KalmanObserver<S>::rest_slope(const Params& p, const S& stress_Pa,
                                            const S& ambient_K) {
  const auto rest = [&](const S& temperature_K) {
    return Kinetics::phases(Kinetics::rest(p.model.kinetics, {temperature_K, stress_Pa}));
  };
  const S away_K = S(5);
  const Phases<S> warm = rest(ambient_K + away_K);
  const Phases<S> cold = rest(ambient_K - away_K);
  return {(warm.martensite - cold.martensite) / (S(2) * away_K),
          (warm.r_phase - cold.r_phase) / (S(2) * away_K)};
}

template <class S>
void KalmanObserver<S>::start_at_rest(const Params& p, State& s, const Measurement<S>& m,
                                      const S& ambient_K, const PhaseRates<S>& rest_slope) {
  const KalmanTuning<S>& t = p.tuning;
  const Phases<S> rest =
      Kinetics::phases(Kinetics::rest(p.model.kinetics, {ambient_K, m.stress_Pa}));
  start(p, s, m, ambient_K, ambient_K, rest, t.start_fraction_sd, t.start_temperature_sd_K);
  // In a warmer room the resting wire would be warmer and have other phases.
  s.covariance.at(iAmbient, iAmbient) = S(0);
  add_along(s.covariance, {S(1), rest_slope.martensite_1_K, rest_slope.r_phase_1_K, S(1)},
            t.start_ambient_sd_K * t.start_ambient_sd_K);
}

template <class S>
void KalmanObserver<S>::add_along(Covariance<S>& P, const S (&along)[4], const S& variance) {
  for (int i = 0; i <= iAmbient; ++i) {
    for (int j = 0; j <= iAmbient; ++j) {
      P.at(i, j) += along[i] * along[j] * variance;
    }
  }
}

template <class S>
void KalmanObserver<S>::start(const Params& p, State& s, const Measurement<S>& m,
                              const S& ambient_K, const S& temperature_K, const Phases<S>& phases,
                              const S& fraction_sd, const S& temperature_sd_K) {
  const KalmanTuning<S>& t = p.tuning;
  s = {};
  Kinetics::start(p.model.kinetics, s.kinetics, {temperature_K, m.stress_Pa}, phases);
  s.rates = Kinetics::rates(p.model.kinetics, s.kinetics, Heading::cooling);
  s.ambient_K = ambient_K;
  s.start_ambient_K = ambient_K;
  s.loss = S(1);
  s.loss_range = t.loss_range;
  s.resistance = S(1);
  s.load_Pa = m.stress_Pa;
  s.slow_load_Pa = m.stress_Pa;
  s.stress_Pa = m.stress_Pa;
  const S sd[size] = {temperature_sd_K,     fraction_sd,     fraction_sd,
                      t.start_ambient_sd_K, t.start_loss_sd, t.start_resistance_sd};
  for (int i = 0; i < size; ++i) {
    s.covariance.at(i, i) = sd[i] * sd[i];
  }
  s.model_ohm = expected(p, s).ohm;
}

template <class S>
void KalmanObserver<S>::go_on(const Params& p, State& s, const S& power_W, Heading heading) {
  const S above_K = s.kinetics.drive.temperature_K - s.ambient_K;
  const S balance = power_W / p.model.body.loss_W(above_K);
  const S loss = heading == Heading::cooling
                     ? beyond_balance * (s.loss < balance ? balance : s.loss)
                     : min(s.loss, balance) / beyond_balance;
  s.loss_range = s.loss_range < moved_loss_range ? moved_loss_range : s.loss_range;
  s.loss = clamp(loss, S(1) / s.loss_range, s.loss_range);
  s.rates = Kinetics::rates(p.model.kinetics, s.kinetics, heading);
  s.heat_J = S(0);
  s.mismatch = S(0);
  s.bias = S(0);
  s.unproven = S(1);
  S variance[size];
  for (int i = 0; i < size; ++i) {
    variance[i] = s.covariance.at(i, i);
  }
  variance[iT] = S(0);
  variance[iLoss] = moved_loss_sd * moved_loss_sd;
  s.covariance = {};
  for (int i = 0; i < size; ++i) {
    s.covariance.at(i, i) = variance[i];
  }
  add_along(s.covariance, {S(1), s.rates.martensite_1_K, s.rates.r_phase_1_K, S(0)},
            moved_temperature_sd_K * moved_temperature_sd_K);
}

template <class S>
void KalmanObserver<S>::advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s) {
  if (m.stress_valid) {
    const S alpha = dt_s / (dt_s + p.tuning.stress_filter_s);
    s.load_Pa += alpha * (m.stress_Pa - s.load_Pa);
  }
  s.slow_load_Pa += dt_s / (dt_s + S(0.5)) * (s.load_Pa - s.slow_load_Pa);
  const S before_Pa = s.stress_Pa;
  s.stress_Pa = s.load_Pa;
  const Linear f = S(0) < p.stop_strain ? predict_at_stop(p, s, m.power_W, dt_s, before_Pa)
                                        : predict_mean(p, s, m.power_W, dt_s);
  s.unproven *= positive(S(1) - S(2) * (f.converted_m + f.converted_r));
  predict_covariance(p, s.covariance, f, dt_s);
  const Expected expect = expected(p, s);
  s.model_ohm = expect.ohm;
  s.innovation_ohm = S(0);
  if (m.resistance_valid && !held(s)) {
    correct(p, s, m, f, expect, dt_s);
  }
}

template <class S>
Estimate<S> KalmanObserver<S>::estimate(const Params& p, const State& s) {
  using std::sqrt;
  const Phases<S> z = p.model.ends.average(Kinetics::phases(s.kinetics));
  const StrainSlopes<S> by = strain_slopes(p.model.material, s.stress_Pa);
  const S by_m = (S(1) - p.model.ends.share) * by.martensite;
  const S by_r = (S(1) - p.model.ends.share) * by.r_phase;
  const Covariance<S>& P = s.covariance;
  const S variance =
      by_m * by_m * P.at(iM, iM) + S(2) * by_m * by_r * P.at(iM, iR) + by_r * by_r * P.at(iR, iR);
  const S unproven = s.unproven * unproven_sd;
  return {strain(p.model.material, z, s.stress_Pa),
          sqrt(p.tuning.reported * p.tuning.reported * (variance < S(0) ? S(0) : variance) +
               p.tuning.strain_model_sd * p.tuning.strain_model_sd + unproven * unproven),
          Kinetics::drive(s.kinetics).temperature_K,
          z.martensite,
          z.r_phase,
          s.model_ohm,
          contradicted(s) ? Health::doubtful : Health::good};
}

/// One step of heat balance and kinetics, like Plant's without substeps.
template <class S>
auto KalmanObserver<S>::predict_mean(const Params& p, State& s, const S& power_W, const S& dt_s)
    -> Linear {
  const ThermalBody<S>& body = p.model.body;
  typename Kinetics::State& k = s.kinetics;
  const S above = k.drive.temperature_K - s.ambient_K;
  const S unit_loss_J = body.loss_W(above) * dt_s;
  const S heat_J = s.heat_J + power_W * dt_s - s.loss * unit_loss_J;
  const S loss_J_K = s.loss * body.loss_slope_W_K(above) * dt_s;
  const Heading heading = S(0) < heat_J ? Heading::heating : Heading::cooling;
  const bool onward = heading == k.heading;
  const Phases<S> before = Kinetics::phases(k);
  PhaseRates<S> rates_before = onward ? s.rates : PhaseRates<S>{S(0), S(0)};
  const S dT = heat_J / (body.effective_capacity_J_K(rates_before) + loss_J_K);

  typename Kinetics::Tangent tangent =
      Kinetics::advance_linearised(p.model.kinetics, k, {k.drive.temperature_K + dT, s.stress_Pa});
  s.rates = tangent.rates;
  const S dM = k.martensite - before.martensite;
  const S dR = k.r_phase - before.r_phase;
  s.heat_J = heat_J - (body.capacity_J_K + loss_J_K) * dT + body.latent_m2a_J * dM +
             body.latent_r2a_J * dR;

  // At a corner of the path there is no derivative; that of the branch after it is used.
  const bool straight = onward && k.heading == heading;
  if (!straight) {
    tangent.transfer = {S(1), S(0), S(0), S(1)};
    if (k.heading != heading) {
      tangent.rates = {S(0), S(0)};
    }
  }
  const bool acts = rates_before.martensite_1_K < S(0) && tangent.rates.martensite_1_K < S(0);
  if (!straight || !acts) {
    rates_before = tangent.rates;
  }
  const typename Kinetics::Transfer& t = tangent.transfer;
  const PhaseRates<S> moved{t.m_m * rates_before.martensite_1_K + t.m_r * rates_before.r_phase_1_K,
                            t.r_m * rates_before.martensite_1_K + t.r_r * rates_before.r_phase_1_K};

  // Derivatives of the heat that the step takes up. With the carried heat_J the enthalpy is exact.
  const S per = S(1) / (body.effective_capacity_J_K(tangent.rates) + loss_J_K);
  Vector temperature = Vector::Zero();
  temperature[iT] = body.effective_capacity_J_K(moved) * per;
  temperature[iM] = (body.latent_m2a_J * (t.m_m - S(1)) + body.latent_r2a_J * t.r_m) * per;
  temperature[iR] = (body.latent_m2a_J * t.m_r + body.latent_r2a_J * (t.r_r - S(1))) * per;
  temperature[iAmbient] = loss_J_K * per;
  temperature[iLoss] = -(unit_loss_J * per);

  // Noise whose standard deviation grows until the heat loss limits it to sd_K. The 6 K account for
  // the air temperature, which is not known exactly, either.
  const S sd_K = p.tuning.heat_error * (magnitude(above) + S(6));
  const S noise_K2 = S(2) * sd_K * sd_K * body.loss_W_K * dt_s / body.capacity_J_K;
  return {temperature, tangent, moved, noise_K2, magnitude(dM), magnitude(dR)};
}

/// A step at the load's stress, or, where the wire would then be shorter than the stop allows, at
/// the stress that keeps it there. Secant steps within a bracket find it, from that of the step
/// before: where a heating transition is steeper over stress than a cooling one, several stresses
/// give a strain, and the nearest is meant.
template <class S>
auto KalmanObserver<S>::predict_at_stop(const Params& p, State& s, const S& power_W, const S& dt_s,
                                        const S& before_Pa) -> Linear {
  constexpr int most_steps = 12;
  constexpr S exact = S(1e-6);
  constexpr S most_Pa = S(1.5e9);  // no wire bears more
  constexpr S usual_compliance_1_Pa = S(2e-11);
  const typename Kinetics::State kinetics = s.kinetics;
  const PhaseRates<S> rates = s.rates;
  const S heat_J = s.heat_J;
  Linear f;
  const auto excess = [&](const S& stress_Pa) {
    s.kinetics = kinetics;
    s.rates = rates;
    s.heat_J = heat_J;
    s.stress_Pa = stress_Pa;
    f = predict_mean(p, s, power_W, dt_s);
    return whole_strain(p, s) - p.stop_strain;
  };
  S low = s.load_Pa;
  S high = most_Pa;
  S last = low;
  S last_excess = excess(low);
  if (!(last_excess < S(0))) {
    return f;
  }
  S compliance = usual_compliance_1_Pa;
  S at = low < before_Pa ? before_Pa : low - last_excess / compliance;
  for (int i = 0; i < most_steps; ++i) {
    at = low < at && at < high ? at : S(0.5) * (low + high);
    const S here = excess(at);
    if (magnitude(here) < exact) {
      break;
    }
    (here < S(0) ? low : high) = at;
    const S slope = (here - last_excess) / (at - last);
    compliance = S(0) < slope ? slope : compliance;
    // A secant that stays at one side may creep: the next one goes twice as far.
    compliance *= i > 0 && (here < S(0)) == (last_excess < S(0)) ? S(0.5) : S(1);
    last = at;
    last_excess = here;
    at -= here / compliance;
  }
  return f;
}

/// P <- F P Fᵀ + Q. Heat that the balance does not include moves temperature and phases together;
/// the fraction that was converted has an error of its own.
template <class S>
void KalmanObserver<S>::predict_covariance(const Params& p, Covariance<S>& P, const Linear& f,
                                           const S& dt_s) {
  const typename Kinetics::Transfer& t = f.tangent.transfer;
  const KalmanTuning<S>& q = p.tuning;
  P.propagate({f.temperature,
               {t.m_m, t.m_r, -f.moved.martensite_1_K},
               {t.r_m, t.r_r, -f.moved.r_phase_1_K},
               f.tangent.rates.martensite_1_K,
               f.tangent.rates.r_phase_1_K},
              f.noise_K2);
  const S per_fraction = q.fraction_noise * q.fraction_noise;
  P.at(iM, iM) += per_fraction * f.converted_m;
  P.at(iR, iR) += per_fraction * f.converted_r;
  P.at(iAmbient, iAmbient) += q.ambient_walk_K * q.ambient_walk_K * dt_s;
  P.at(iLoss, iLoss) += q.loss_walk * q.loss_walk * dt_s;
  P.at(iResistance, iResistance) += q.resistance_walk * q.resistance_walk * dt_s;
}

template <class S>
auto KalmanObserver<S>::expected(const Params& p, const State& s) -> Expected {
  const Material<S>& material = p.model.material;
  const ColdEnds<S>& ends = p.model.ends;
  const S middle = S(1) - ends.share;
  const S T = Kinetics::drive(s.kinetics).temperature_K;
  const Phases<S> z = ends.average(Kinetics::phases(s.kinetics));
  const Resistivity<S> rho =
      resistivity(material, z, {ends.average_K(T, s.ambient_K), s.stress_Pa});
  const StrainSlopes<S> by = strain_slopes(material, s.stress_Pa);
  // R = ρ L_0/A_0 (1 + 2 ε)
  const S unit = p.model.length_per_area_1_m;
  const S scale = s.resistance * unit;
  const S stretch =
      S(1) + S(2) * (by.austenite + z.martensite * by.martensite + z.r_phase * by.r_phase);
  Vector slope = Vector::Zero();
  slope[iT] = scale * rho.per_K * stretch * middle;
  slope[iM] = scale * middle * (rho.per_martensite * stretch + S(2) * rho.value * by.martensite);
  slope[iR] = scale * middle * (rho.per_r_phase * stretch + S(2) * rho.value * by.r_phase);
  slope[iAmbient] = scale * rho.per_K * stretch * ends.share;
  slope[iResistance] = unit * rho.value * stretch;
  return {scale * rho.value * stretch, slope};
}

/// Changes a correction to the most likely one that keeps all fractions within the simplex: a
/// fraction that would become negative is treated as measured exactly at its bound, which moves the
/// other states as well. If it were only clipped, a correction that takes from one phase and gives
/// to another would only give, and the filter would diverge.
template <class S>
void KalmanObserver<S>::keep_on_simplex(const Covariance<S>& P, const Phases<S>& z,
                                        Vector& change) {
  const S martensite = z.martensite + change[iM];
  const S r_phase = z.r_phase + change[iR];
  if (r_phase < S(0)) {
    change -= (r_phase / P.at(iR, iR)) * P.row(iR);
  } else if (martensite < S(0)) {
    change -= (martensite / P.at(iM, iM)) * P.row(iM);
  } else if (S(1) < martensite + r_phase) {
    const Vector sum = P.row(iM) + P.row(iR);
    change -= ((martensite + r_phase - S(1)) / (sum[iM] + sum[iR])) * sum;
  }
}

/// σ² = Hᵀ P H plus the variances of model and sensors.
template <class S>
S KalmanObserver<S>::innovation_variance(const Params& p, const Expected& expect, const Vector& PH,
                                         const Measurement<S>& m, const S& dt_s) {
  const S model_sd = p.tuning.resistance_model_sd * expect.ohm;
  return Covariance<S>::variance(expect.slope, PH) + model_sd * model_sd * (S(1e-3) / dt_s) +
         m.resistance_sd_ohm * m.resistance_sd_ohm;
}

/// With y = measured less expected resistance and its variance σ²:
/// K = P H/σ²,  x <- x + K y,  P <- P - K (P H)ᵀ.
template <class S>
void KalmanObserver<S>::correct(const Params& p, State& s, const Measurement<S>& m, const Linear& f,
                                const Expected& expect, const S& dt_s) {
  const KalmanTuning<S>& q = p.tuning;
  Covariance<S>& P = s.covariance;
  const Vector PH = P.times(expect.slope);
  const S variance = innovation_variance(p, expect, PH, m, dt_s);
  const S innovation = m.resistance_ohm - expect.ohm;
  const Vector K = (S(1) / variance) * PH;
  P.update(K, PH);
  Vector change = innovation * K;
  const Phases<S> z = Kinetics::phases(s.kinetics);
  keep_on_simplex(P, z, change);
  const S martensite = clamp(z.martensite + change[iM], S(0), S(1));
  const S r_phase = clamp(z.r_phase + change[iR], S(0), S(1) - martensite);
  const S T = s.kinetics.drive.temperature_K;
  const S warmer_K = clamp(T + change[iT], s.start_ambient_K - q.ambient_range_K, q.hottest_K) - T;
  Kinetics::correct(p.model.kinetics, s.kinetics, f.tangent, warmer_K, {martensite, r_phase});
  s.ambient_K = clamp(s.ambient_K + change[iAmbient], s.start_ambient_K - q.ambient_range_K,
                      s.start_ambient_K + q.ambient_range_K);
  s.loss = clamp(s.loss + change[iLoss], S(1) / s.loss_range, s.loss_range);
  s.resistance = clamp(s.resistance + change[iResistance], S(1) - q.resistance_range,
                       S(1) + q.resistance_range);
  s.innovation_ohm = innovation;
  s.innovation_variance = variance;
  const S relative = innovation / expect.ohm;
  s.mismatch += dt_s / (dt_s + S(2)) * (magnitude(relative) - s.mismatch);
  const S weight = dt_s / (dt_s + S(0.1));
  s.bias += weight * (relative - s.bias);
  s.noise += weight * (m.resistance_sd_ohm / expect.ohm - s.noise);
}

}  // namespace smaservo
