#pragma once
// Where the multiple-model filter starts to look for a wire of which nothing but one resistance is
// known: guesses of its temperature and phases that explain this resistance, as far as they can.

#include <cstddef>

#include "model/scalar/order.hpp"
#include "observer/kalman.hpp"

namespace smaservo {

/// Starts of hypotheses 1 to 5. Hypothesis 0, cold and at rest, is KalmanObserver::start_at_rest().
template <class S>
struct StartHypotheses {
  using Filter = KalmanObserver<S>;
  using Params = typename Filter::Params;

  static constexpr std::size_t count = 6;
  /// Number of temperatures at which the most R-phase is looked for.
  static constexpr int places = 12;

  /// The most R-phase that the wire has at rest at `number` of the temperatures, from the one with
  /// index `first` on. Cost: `number` starts of the kinetics.
  static S most_r_phase(const Params& p, const S& stress_Pa, int first, int number);

  /// Starts a filter as hypothesis `i`. 1: about to contract; 2: about to stretch; 3 and 4: in the
  /// middle of a loop, austenite with martensite or with R-phase; 5: hot. 2 and 4 have at most
  /// `max_r_phase` of R-phase, what the wire can have on cooling, the others next to none. `m` must
  /// have a valid stress and resistance.
  static void start(const Params& p, typename Filter::State& f, std::size_t i,
                    const Measurement<S>& m, const S& ambient_K, const S& max_r_phase);

 private:
  static constexpr S place_distance_K = S(2.5);
  /// Initial deviations for a wire that is seen in motion: a single resistance must tell phases,
  /// drift and surroundings apart. With much freedom for drift and surroundings, several hypotheses
  /// would explain everything for ever.
  static constexpr S moving_loss_sd = S(0.4);
  static constexpr S moving_resistance_sd = S(0.01);

  /// The temperatures at which heating and cooling begin to transform, and their mean.
  struct Loop {
    S heats_K, cools_K, between_K;
  };
  static Loop loop(const Params& p, const S& stress_Pa);
  static S matching_share(const Params& p, const Measurement<S>& m, const S& ambient_K,
                          const S& temperature_K, bool martensite);
};

template <class S>
S StartHypotheses<S>::most_r_phase(const Params& p, const S& stress_Pa, int first, int number) {
  const S from_K = loop(p, stress_Pa).between_K;
  S most = S(0);
  for (int i = first; i < first + number; ++i) {
    const S at_K = from_K - place_distance_K * S(i);
    const S r = Filter::Kinetics::rest(p.model.kinetics, {at_K, stress_Pa}).r_phase;
    most = most < r ? r : most;
  }
  return most;
}

template <class S>
auto StartHypotheses<S>::loop(const Params& p, const S& stress_Pa) -> Loop {
  const typename Filter::Kinetics::Params& k = p.model.kinetics;
  const S heats_K = isobar(k.m2a, stress_Pa).start_K;
  const S cools_K = isobar(k.a2m_a2r, Pair<S>(stress_Pa)).start_K.first();
  return {heats_K, cools_K, (heats_K + cools_K) / S(2)};
}

template <class S>
void StartHypotheses<S>::start(const Params& p, typename Filter::State& f, std::size_t i,
                               const Measurement<S>& m, const S& ambient_K, const S& max_r_phase) {
  const Loop at = loop(p, m.stress_Pa);
  const S martensite = matching_share(p, m, ambient_K, at.between_K, true);
  const S r_phase = matching_share(p, m, ambient_K, at.between_K, false);
  // The part of the resistance that R-phase cannot explain is due to martensite.
  const auto mixture = [&](const S& share) {
    const S r = min(share * r_phase, max_r_phase);
    return Phases<S>{S(0.03) + (S(1) - r / r_phase) * min(martensite, S(0.95)) * S(0.97), r};
  };
  struct Guess {
    S temperature_K;
    Phases<S> phases;
  };
  const auto guess = [&]() -> Guess {
    switch (i) {
      case 1:
        return {at.heats_K - S(5), {martensite, S(0.01)}};
      case 2:
        return {at.cools_K + S(3), mixture(S(0.4))};
      case 3:
        return {at.between_K, {martensite, S(0.01)}};
      case 4:
        return {at.between_K, mixture(S(1))};
      default:
        return {at.heats_K + S(25), {min(martensite, S(0.3)), S(0.01)}};
    }
  };
  const Guess first = guess();
  Filter::start(p, f, m, ambient_K, first.temperature_K, first.phases, S(0.15), S(8));
  f.covariance.at(Filter::iLoss, Filter::iLoss) = moving_loss_sd * moving_loss_sd;
  f.covariance.at(Filter::iResistance, Filter::iResistance) =
      moving_resistance_sd * moving_resistance_sd;
}

/// The share of martensite (or else of R-phase) in austenite that explains the resistance.
template <class S>
S StartHypotheses<S>::matching_share(const Params& p, const Measurement<S>& m, const S& ambient_K,
                                     const S& temperature_K, bool martensite) {
  const auto ohm = [&](const S& share) {
    return Filter::Model::resistance_ohm(
        p.model, martensite ? Phases<S>{share, S(0)} : Phases<S>{S(0), share},
        {temperature_K, m.stress_Pa}, ambient_K);
  };
  const S none = ohm(S(0));
  const S all = ohm(S(1));
  const S share = (m.resistance_ohm - none) / (all - none);
  return share < S(0.02) ? S(0.02) : S(0.95) < share ? S(0.95) : share;
}

}  // namespace smaservo
