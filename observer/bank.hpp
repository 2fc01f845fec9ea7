#pragma once
// Several filters that start from different ideas of where the wire is, until the resistance has
// told which one is right. A single filter that starts from the wrong phase stays there.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "observer/kalman.hpp"

namespace smaservo {

template <class S>
struct KalmanBank {
  using Scalar = S;
  using Filter = KalmanObserver<S>;
  using Params = typename Filter::Params;

  static constexpr std::size_t hypotheses = 6;

  struct State {
    std::array<typename Filter::State, hypotheses> filter;
    std::array<S, hypotheses> log_likelihood;  ///< of the resistance; a common constant is left out
    std::array<S, hypotheses> log_weight;      ///< with log_prior(), relative to the best one
    std::array<bool, hypotheses> at_rest;      ///< it started cold and at rest
    std::uint8_t alive;                        ///< the first so many are in use
    S start_ambient_K;
    bool compared;  ///< there has been a valid resistance
    S doubt_s;      ///< for how long the last filter has contradicted the resistance
  };

  static State start(const Params& p, const Measurement<S>& m, const S& ambient_K);

  /// Cost: one filter step for each hypothesis that is still possible; one, soon.
  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s);

  /// The most likely hypothesis.
  static const typename Filter::State& likeliest(const State& s) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < s.alive; ++i) {
      best = s.log_weight[best] < s.log_weight[i] ? i : best;
    }
    return s.filter[best];
  }

  /// The mean of the hypotheses by their likelihood, with their scatter in the deviation.
  static Estimate<S> estimate(const Params& p, const State& s);

 private:
  /// A wire that was switched on is nearly always cold and at rest: exp(4) times as likely.
  static constexpr S other_starts = S(-4);
  /// A hypothesis is given up when it is exp(10) times less likely than the best one. To wait for
  /// more is not safer: the model's own errors then decide.
  static constexpr S least_log_weight = S(-10);

  /// Who has not seen the wire at rest does not know what its resistance was there: 2 % of 4 %
  /// stroke, for long.
  static constexpr S unseen_rest_sd = S(8e-4);

  /// A wire that is seen in motion has one resistance to tell phases, drift and surroundings apart:
  /// with much freedom for the last two, several starts would go on to explain everything.
  static constexpr S moving_loss_sd = S(0.4);
  static constexpr S moving_resistance_sd = S(0.01);

  /// Hypotheses whose strains scatter by less, 2.5 % of 4 % stroke, are no longer a question.
  static constexpr S agreed_sd = S(1e-3);

  /// What a hypothesis has to believe of the air and of a drift to explain the resistance counts
  /// against it: the filters themselves leave both nearly free.
  static constexpr S plausible_ambient_sd_K = S(10);
  static constexpr S plausible_loss_sd = S(0.25);
  static constexpr S plausible_resistance_sd = S(0.01);
  static S log_prior(const typename Filter::State& f);

  /// The most R-phase that a wire has on cooling.
  static S greatest_r_phase(const Params& p, const S& stress_Pa, const S& from_K);

  static S least(const S& a, const S& b) { return a < b ? a : b; }

  static Estimate<S> estimate_one(const Params& p, const State& s, std::size_t i);
  static void restart(const Params& p, State& s, const Measurement<S>& m);
  static void weigh(State& s);
  static bool agree(const typename Filter::State& a, const typename Filter::State& b);
  static S matching_share(const Params& p, const Measurement<S>& m, const S& ambient_K,
                          const S& temperature_K, bool martensite);
};

/// Share of martensite (or else R-phase) in austenite that explains the resistance.
template <class S>
S KalmanBank<S>::matching_share(const Params& p, const Measurement<S>& m, const S& ambient_K,
                                const S& temperature_K, bool martensite) {
  const auto ohm = [&](const S& share) {
    const Phases<S> z = martensite ? Phases<S>{share, S(0)} : Phases<S>{S(0), share};
    return Filter::expected(p, Filter::start(p, m, ambient_K, temperature_K, z, S(0.1), S(8))).ohm;
  };
  const S none = ohm(S(0));
  const S all = ohm(S(1));
  const S share = (m.resistance_ohm - none) / (all - none);
  return share < S(0.02) ? S(0.02) : S(0.95) < share ? S(0.95) : share;
}

template <class S>
S KalmanBank<S>::log_prior(const typename Filter::State& f) {
  const S ambient = (f.ambient_K - f.start_ambient_K) / plausible_ambient_sd_K;
  const S loss = (f.loss - S(1)) / plausible_loss_sd;
  const S resistance = (f.resistance - S(1)) / plausible_resistance_sd;
  return S(-0.5) * (ambient * ambient + loss * loss + resistance * resistance);
}

template <class S>
S KalmanBank<S>::greatest_r_phase(const Params& p, const S& stress_Pa, const S& from_K) {
  S greatest = S(0);
  for (int i = 0; i < 10; ++i) {
    const S at_K = from_K - S(3) * S(i);
    const S r = Filter::Kinetics::rest(p.model.kinetics, {at_K, stress_Pa}).r_phase;
    greatest = greatest < r ? r : greatest;
  }
  return greatest;
}

template <class S>
auto KalmanBank<S>::start(const Params& p, const Measurement<S>& m, const S& ambient_K) -> State {
  const typename Filter::Kinetics::Params& k = p.model.kinetics;
  const S heats_at = isobar(k.m2a, m.stress_Pa).start_K;
  const S cools_at = isobar(k.a2m_a2r, Pair<S>(m.stress_Pa)).start_K.first();
  const S between = (heats_at + cools_at) / S(2);
  State s{};
  s.start_ambient_K = ambient_K;
  s.compared = m.resistance_valid;
  const auto add = [&](const S& temperature_K, const Phases<S>& z) {
    s.log_likelihood[s.alive] = other_starts;
    s.log_weight[s.alive] = other_starts;
    typename Filter::State& f = s.filter[s.alive++];
    f = Filter::start(p, m, ambient_K, temperature_K, z, S(0.15), S(8));
    f.covariance[Filter::iLoss][Filter::iLoss] = moving_loss_sd * moving_loss_sd;
    f.covariance[Filter::iResistance][Filter::iResistance] =
        moving_resistance_sd * moving_resistance_sd;
  };
  // Cold and at rest; about to contract; about to stretch; in the middle of a loop, martensite or
  // R-phase with austenite; hot.
  s.at_rest[0] = true;
  s.filter[s.alive++] = Filter::start(p, m, ambient_K);
  if (m.resistance_valid) {
    const S martensite = matching_share(p, m, ambient_K, between, true);
    const S r_phase = matching_share(p, m, ambient_K, between, false);
    const S most_r = greatest_r_phase(p, m.stress_Pa, between);
    // What the R-phase can not explain is martensite.
    const auto mixture = [&](const S& share) {
      const S r = least(share * r_phase, most_r);
      return Phases<S>{S(0.03) + (S(1) - r / r_phase) * least(martensite, S(0.95)) * S(0.97), r};
    };
    add(heats_at - S(5), {martensite, S(0.01)});
    add(cools_at + S(3), mixture(S(0.4)));
    add(between, {martensite, S(0.01)});
    add(between, mixture(S(1)));
    add(heats_at + S(25), {martensite < S(0.3) ? martensite : S(0.3), S(0.01)});
  }
  return s;
}

template <class S>
void KalmanBank<S>::advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s) {
  if (!s.compared && m.resistance_valid) {
    restart(p, s, m);
  }
  for (std::size_t i = 0; i < s.alive; ++i) {
    Filter::advance(p, s.filter[i], m, dt_s);
  }
  if (s.alive > 1 && m.resistance_valid) {
    weigh(s);
  }
  const bool doubtful = s.alive == 1 && Filter::estimate(p, s.filter[0]).health == Health::doubtful;
  s.doubt_s = doubtful ? s.doubt_s + dt_s : S(0);
  if (S(1) < s.doubt_s && m.resistance_valid) {
    restart(p, s, m);
    s.log_likelihood = {};
    s.log_weight = {};
  }
}

/// The search begins with the stress that the filter knows; the measurement's may be invalid.
template <class S>
void KalmanBank<S>::restart(const Params& p, State& s, const Measurement<S>& m) {
  Measurement<S> now = m;
  now.stress_Pa = s.filter[0].stress_Pa;
  s = start(p, now, s.start_ambient_K);
}

/// Counts the last innovations; drops what has become unlikely, and of two that agree the less
/// likely one.
template <class S>
void KalmanBank<S>::weigh(State& s) {
  S best = S(0);
  for (std::size_t i = 0; i < s.alive; ++i) {
    const typename Filter::State& f = s.filter[i];
    // Without the logarithm of the variance: the filters count the resistance model's coloured
    // error as white noise, and that term would then decide alone, for the most confident one.
    s.log_likelihood[i] =
        s.log_likelihood[i] - S(0.5) * f.innovation_ohm * f.innovation_ohm / f.innovation_variance;
    s.log_weight[i] = s.log_likelihood[i] + log_prior(f);
    best = i == 0 || best < s.log_weight[i] ? s.log_weight[i] : best;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s.alive; ++i) {
    const S relative = s.log_weight[i] - best;
    if (!(least_log_weight < relative)) {
      continue;
    }
    std::size_t place = 0;
    while (place < kept && !agree(s.filter[place], s.filter[i])) {
      ++place;
    }
    if (place == kept || s.log_weight[place] < relative) {
      if (place != i) {
        s.filter[place] = s.filter[i];
        s.at_rest[place] = s.at_rest[i];
      }
      s.log_likelihood[place] = s.log_likelihood[i] - best;
      s.log_weight[place] = relative;
    }
    kept = place == kept ? kept + 1 : kept;
  }
  s.alive = static_cast<std::uint8_t>(kept);
}

template <class S>
bool KalmanBank<S>::agree(const typename Filter::State& a, const typename Filter::State& b) {
  const auto near = [](const S& x, const S& y, const S& limit) {
    return x - y < limit && y - x < limit;
  };
  return near(a.kinetics.martensite, b.kinetics.martensite, S(0.08)) &&
         near(a.kinetics.r_phase, b.kinetics.r_phase, S(0.08)) &&
         near(a.kinetics.drive.temperature_K, b.kinetics.drive.temperature_K, S(4));
}

template <class S>
Estimate<S> KalmanBank<S>::estimate_one(const Params& p, const State& s, std::size_t i) {
  using std::sqrt;
  Estimate<S> e = Filter::estimate(p, s.filter[i]);
  if (!s.at_rest[i]) {
    e.strain_sd = sqrt(e.strain_sd * e.strain_sd + unseen_rest_sd * unseen_rest_sd);
  }
  return e;
}

template <class S>
Estimate<S> KalmanBank<S>::estimate(const Params& p, const State& s) {
  using std::exp;
  using std::sqrt;
  if (s.alive == 1) {
    return estimate_one(p, s, 0);
  }
  Estimate<S> mean{};
  S weights = S(0);
  S square = S(0);
  S scatter = S(0);
  for (std::size_t i = 0; i < s.alive; ++i) {
    const S w = exp(s.log_weight[i]);
    const Estimate<S> e = estimate_one(p, s, i);
    weights = weights + w;
    mean.strain = mean.strain + w * e.strain;
    square = square + w * (e.strain * e.strain + e.strain_sd * e.strain_sd);
    scatter = scatter + w * e.strain * e.strain;
    mean.temperature_K = mean.temperature_K + w * e.temperature_K;
    mean.martensite = mean.martensite + w * e.martensite;
    mean.r_phase = mean.r_phase + w * e.r_phase;
    mean.resistance_model_ohm = mean.resistance_model_ohm + w * e.resistance_model_ohm;
  }
  mean.strain = mean.strain / weights;
  const S variance = square / weights - mean.strain * mean.strain;
  mean.strain_sd = sqrt(variance < S(0) ? S(0) : variance);
  mean.temperature_K = mean.temperature_K / weights;
  mean.martensite = mean.martensite / weights;
  mean.r_phase = mean.r_phase / weights;
  mean.resistance_model_ohm = mean.resistance_model_ohm / weights;
  scatter = scatter / weights - mean.strain * mean.strain;
  mean.health = scatter < agreed_sd * agreed_sd ? Health::good : Health::searching;
  return mean;
}

}  // namespace smaservo
