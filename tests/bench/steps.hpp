#pragma once
// The steps that are timed by model_bench and counted by count_steps. Each is a callable that does
// one step; `period` of them go once through its whole drive, and the next period repeats it.

#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "model/files/wire/wire_file.hpp"
#include "model/papers/cosine.hpp"
#include "model/wire/plant.hpp"
#include "observer/multiple_model.hpp"
#include "tests/bench/cardano.hpp"
#include "tests/bench/convert.hpp"
#include "tests/bench/cycle.hpp"
#include "tests/bench/ihyp_error.hpp"
#include "tests/model/wire/ordered_wire.hpp"

namespace smaservo::benchmarks {

inline constexpr double stress_Pa = 150e6;
inline constexpr double ambient_K = room_K;

using PlantParams = Plant<ThreePhase<double>>::Params;

inline const PlantParams& default_plant() {
  static const PlantParams params =
      plant_params(files::load_wire(std::string(files::default_wire)).wire);
  return params;
}

inline const PlantParams& ordered_plant() {
  static const PlantParams params = plant_params(test::ordered_wire());
  return params;
}

/// 20 to 110 °C and back in steps of 0.05 K: the first half heats. `spring_Pa` is what the stress
/// gains from one end to the other, around 150 MPa.
template <class S>
std::vector<Drive<S>> triangle(double spring_Pa) {
  constexpr int half = 1800;
  std::vector<Drive<S>> drives;
  for (int i = 1; i <= 2 * half; ++i) {
    const double share = static_cast<double>(i <= half ? i : 2 * half - i) / half;
    drives.push_back(
        {scalar<S>(293.15 + 90 * share), scalar<S>(stress_Pa + spring_Pa * (share - 0.5))});
  }
  return drives;
}

/// What the loop and the table cost by themselves.
template <class S>
class EmptyStep {
 public:
  std::size_t period() const { return drives_.size(); }
  void operator()() { now_ = drives_.next(); }

 private:
  Cycle<Drive<S>> drives_{triangle<S>(0)};
  Drive<S> now_{};
};

template <class S, Split<S> (*inverse)(const IhypShape<S>&, S)>
class InverseStep {
 public:
  std::size_t period() const { return cases_.size(); }
  void operator()() {
    const IhypCase<S>& c = cases_.next();
    now_ = inverse(c.shape, c.tau);
  }

 private:
  Cycle<IhypCase<S>> cases_{whole_ihyp_range<S>(4096)};
  Split<S> now_{};
};

/// The two-phase cosine model with the wire's M2A and A2M temperatures: the yardstick.
template <class S>
typename papers::Cosine<S>::Params cosine_params() {
  const ThreePhase<double>::Params& p = default_plant().kinetics;
  const auto process = [](const Surface<double>& s) {
    return papers::CosineProcess<S>{scalar<S>(s.start_K[0]), scalar<S>(s.finish_K[0]),
                                    scalar<S>(1 / s.start_K[1])};
  };
  return {process(p.m2a), process(first_surface(p.a2m_a2r))};
}

/// Only the temperatures at which the cosine model converts: between them it has nothing to do.
template <class S>
std::vector<Drive<S>> converting_only() {
  const typename papers::Cosine<S>::Params p = cosine_params<S>();
  std::vector<Drive<S>> drives;
  for (const papers::CosineProcess<S>& process : {p.m2a, p.a2m}) {
    constexpr int steps = 1800;
    const auto stress = scalar<S>(stress_Pa);
    const S start_K = process.start_K + stress / process.stress_Pa_K;
    for (int i = 1; i <= steps; ++i) {
      const S share = static_cast<S>(i) / static_cast<S>(steps + 1);
      drives.push_back({start_K + share * (process.finish_K - process.start_K), stress});
    }
  }
  return drives;
}

template <Kinetics K>
class KineticsStep {
 public:
  using S = typename K::Scalar;
  KineticsStep(const typename K::Params& params, std::vector<Drive<S>> drives)
      : params_(params), drives_(std::move(drives)), state_(K::rest(params_, drives_.first())) {}
  std::size_t period() const { return drives_.size(); }
  void operator()() { K::advance(params_, state_, drives_.next()); }

 private:
  typename K::Params params_;
  Cycle<Drive<S>> drives_;
  typename K::State state_;
};

template <class S>
KineticsStep<ThreePhase<S>> three_phase_step(double spring_Pa) {
  return {convert<S>(default_plant().kinetics), triangle<S>(spring_Pa)};
}

/// At constant stress with the surfaces cut before.
template <class S>
class CutStep {
 public:
  std::size_t period() const { return drives_.size(); }
  void operator()() { K::advance(params_, cut_, state_, drives_.next().temperature_K); }

 private:
  using K = ThreePhase<S>;
  typename K::Params params_ = convert<S>(default_plant().kinetics);
  typename K::Cut cut_ = K::cut(params_, scalar<S>(stress_Pa));
  Cycle<Drive<S>> drives_{triangle<S>(0)};
  typename K::State state_ = K::rest(params_, drives_.first());
};

/// A wire at 1 kHz whose power goes up and down within 20 s, with the noise of its sensors.
inline std::vector<Measurement<double>> measurements(const PlantParams& params = default_plant()) {
  using Model = Plant<ThreePhase<double>>;
  Model::State wire = Model::rest(params, {ambient_K, stress_Pa});
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise;
  const double max_W = params.body.loss_W(90);
  constexpr int half = 10000;
  std::vector<Measurement<double>> all;
  for (int i = 0; i < 2 * half; ++i) {
    const double share = static_cast<double>(i < half ? i : 2 * half - i) / half;
    const double power_W = max_W * (0.02 + 0.98 * share);
    Model::advance(params, wire, {power_W, stress_Pa, ambient_K}, 1e-3);
    const double ohm = Model::resistance_ohm(params, wire, ambient_K);
    all.push_back({ohm * (1 + 1e-4 * noise(random)), ohm * 1e-4, power_W,
                   stress_Pa + 0.5e6 * noise(random), true, true, true});
  }
  return all;
}

template <class S>
std::vector<Measurement<S>> measurements(const PlantParams& params = default_plant()) {
  std::vector<Measurement<S>> all;
  for (const Measurement<double>& m : measurements(params)) {
    all.push_back({scalar<S>(m.resistance_ohm), scalar<S>(m.resistance_sd_ohm),
                   scalar<S>(m.power_W), scalar<S>(m.stress_Pa), true, true, true});
  }
  return all;
}

/// The plant's step on the same power: heat balance and kinetics, without an observer.
template <class S>
class PlantStep {
 public:
  std::size_t period() const { return inputs_.size(); }
  void operator()() {
    const Measurement<S>& m = inputs_.next();
    Model::advance(params_, state_, {m.power_W, m.stress_Pa, scalar<S>(ambient_K)}, S(1e-3));
  }

 private:
  using Model = Plant<ThreePhase<S>>;
  typename Model::Params params_ = convert<S>(default_plant());
  Cycle<Measurement<S>> inputs_{measurements<S>()};
  typename Model::State state_ = Model::rest(params_, {scalar<S>(ambient_K), scalar<S>(stress_Pa)});
};

template <StrainObserver O>
class ObserverStep {
 public:
  using S = typename O::Scalar;
  explicit ObserverStep(const typename O::Params& params, const PlantParams& wire = default_plant())
      : params_(params), inputs_(measurements<S>(wire)) {}
  std::size_t period() const { return inputs_.size(); }
  void operator()() { O::advance(params_, state_, inputs_.next(), S(1e-3)); }

 private:
  typename O::Params params_;
  Cycle<Measurement<S>> inputs_;
  typename O::State state_ = O::start(params_, inputs_.first(), scalar<S>(ambient_K));
};

/// Calls f(name, make) for every kind of step of our own; make() builds it.
template <class S, class F>
void for_each_step(F f) {
  f("empty", [] { return EmptyStep<S>(); });
  f("ihyp_inverse", [] { return InverseStep<S, ihyp_fraction<S>>(); });
  f("ihyp_inverse_cardano", [] { return InverseStep<S, cardano_fraction<S>>(); });
  f("ihyp_inverse_newton", [] { return InverseStep<S, newton_fraction<S>>(); });
  f("cosine_step",
    [] { return KineticsStep<papers::Cosine<S>>(cosine_params<S>(), triangle<S>(0)); });
  f("cosine_step_converting",
    [] { return KineticsStep<papers::Cosine<S>>(cosine_params<S>(), converting_only<S>()); });
  f("model_step_cut", [] { return CutStep<S>(); });
  f("model_step_constant_stress", [] { return three_phase_step<S>(0); });
  f("model_step_varying_stress", [] { return three_phase_step<S>(100e6); });
  f("plant_step", [] { return PlantStep<S>(); });
  f("observer_step",
    [] { return ObserverStep<KalmanObserver<S>>({convert<S>(default_plant()), {}}); });
  f("observer_step_ordered", [] {
    return ObserverStep<KalmanObserver<S>>({convert<S>(ordered_plant()), {}}, ordered_plant());
  });
  f("multiple_model_step",
    [] { return ObserverStep<MultipleModelFilter<S>>({convert<S>(default_plant()), {}}); });
}

}  // namespace smaservo::benchmarks
