#pragma once
// Multiple-model filter: several Kalman filters start from different hypotheses about the wire's
// state, and each is weighed by the likelihood of its innovations until the resistance has shown
// which one is right. A single filter that starts from wrong phases keeps them.
//
// Once one is left, it may still be led astray by air that begins to move, or stops: with another
// loss the wire has another temperature. Then two more hypotheses leave from it, one on the path of
// cooling and one on that of heating, to where the resistance is as measured.
//
// The work of a search is spread over many calls, so that none costs more than two steps of a
// filter: observer/README.md, 'The multiple-model filter'.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "observer/kalman.hpp"
#include "observer/start_hypotheses.hpp"

namespace smaservo {

/// Kalman filters that start from six hypotheses; the likeliest gives the estimate. It is an
/// observer (StrainObserver) for a wire of which nothing is known at the start.
template <class S>
struct MultipleModelFilter {
  using Scalar = S;
  using Filter = KalmanObserver<S>;
  using Params = typename Filter::Params;

  static constexpr std::size_t hypotheses = StartHypotheses<S>::count;

  /// The measurements that a filter has not processed yet.
  struct Missed {
    S time_s;
    S energy_J;
  };

  /// The hypotheses and how likely they are; trivially copyable.
  struct State {
    /// Hypothesis i starts as open() defines it, or as a walker of walk().
    std::array<typename Filter::State, hypotheses> filter;
    std::array<Missed, hypotheses> missed;
    std::array<Estimate<S>, hypotheses> last;  ///< estimate after each filter's last step
    /// Log-likelihood of the measured resistances, up to a common constant.
    std::array<S, hypotheses> log_likelihood;
    /// log_likelihood plus log_prior(), relative to the best one; without log_prior() if air_moved.
    std::array<S, hypotheses> log_weight;
    std::uint8_t alive;  ///< bit i: hypothesis i is still possible
    /// The most likely hypothesis; until a search has opened all hypotheses, the leader before it.
    std::uint8_t leader;
    std::uint8_t follower;     ///< the last one besides the leader that made a step
    std::uint8_t last_opened;  ///< the hypothesis that the search opened last
    std::uint8_t unopened;     ///< number of hypotheses that the search has still to open
    /// Number of temperatures at which the search has looked for R-phase. On a path: 0 before the
    /// leader was copied, then one more than the steps that the walker has made.
    std::uint8_t places;
    S max_r_phase;             ///< most R-phase found at these temperatures
    PhaseRates<S> rest_slope;  ///< change of the phases at rest per kelvin of ambient temperature
    bool rest_slope_known;     ///< the search has computed rest_slope
    S others_start;            ///< initial log-likelihood of hypotheses that do not start at rest
    S start_ambient_K;
    bool compared;           ///< there has been a valid resistance
    S heat_J;                ///< heat since the hypotheses began to compete, as fade() counts it
    std::uint8_t seen_rest;  ///< bit i: hypothesis i has seen the wire's resistance at rest
    bool air_moved;          ///< walkers have set out since the last search
    std::uint8_t origin;     ///< the leader when they set out last
    S moves;              ///< how often a walker has become the leader and strayed, fading over 5 s
    S first_missing_ohm;  ///< what the walker's resistance lacked where it began
    S missing_ohm;        ///< and what it lacks now
    std::uint8_t paths;   ///< 2 on the path to the cold, 1 on that to the heat, else 0
    std::uint8_t arrived;  ///< bit i: filter i is a walker that has found the resistance
    S doubt_s;  ///< time away from the stop for which the leader has contradicted the resistance
  };

  /// Cost: one start at rest, two steps of the filter.
  static State start(const Params& p, const Measurement<S>& m, const S& ambient_K) {
    State s{};
    start(p, s, m, ambient_K);
    return s;
  }
  /// Like start() above, but in place: a state takes kilobytes, which a small stack does not have.
  static void start(const Params& p, State& s, const Measurement<S>& m, const S& ambient_K);

  /// Cost: one step of a filter; during a search one more, or a part of an opening or of a walker's
  /// path that costs as much. The most likely hypothesis makes a step in each call, since the
  /// device's protection relies on it; the others take turns, and a step of theirs covers all that
  /// they have missed.
  static void advance(const Params& p, State& s, const Measurement<S>& m, const S& dt_s);

  /// The most likely hypothesis.
  static const typename Filter::State& likeliest(const State& s) { return s.filter[s.leader]; }

  /// The number of hypotheses that are still possible.
  static int alive(const State& s) { return std::popcount(s.alive); }

  /// The mean of the hypotheses weighed by their likelihood; the deviation includes their scatter.
  /// While a search is still opening hypotheses: the estimate of the leader before it, with
  /// unknown_sd added to the deviation and the health `searching`.
  static Estimate<S> estimate(const Params& /*p*/, const State& s) { return estimate(s); }

 private:
  using Starts = StartHypotheses<S>;

  /// Initial log-likelihood of the other hypotheses: a wire that was switched on is nearly always
  /// cold and at rest, exp(4) times as likely.
  static constexpr S other_starts = S(-4);
  /// A hypothesis is dropped when it is exp(10) times less likely than the best one. A wider margin
  /// is not safer: the errors of the model would then decide.
  static constexpr S min_log_weight = S(-10);

  /// Added to the deviation of a hypothesis that did not start at rest and therefore has not seen
  /// the wire's resistance at rest: 2 % of a 4 % stroke, as long as it lives.
  static constexpr S unseen_rest_sd = S(8e-4);
  /// Factor on the bias of the innovation that such a hypothesis may have before the air is blamed.
  static constexpr S unseen_rest_bias = S(3);

  /// Standard deviation of a strain that may be anywhere in a 4 % stroke: 4 %/sqrt(12).
  static constexpr S unknown_sd = S(0.0115);

  /// While several hypotheses live, the health is good if their strains scatter by less than this
  /// (2.5 % of a 4 % stroke), else searching.
  static constexpr S agreed_sd = S(1e-3);

  /// Standard deviations of log_prior(): a hypothesis becomes less likely if it needs unusual air,
  /// loss or drift to explain the resistance, which the filters themselves leave nearly free.
  static constexpr S plausible_ambient_sd_K = S(10);
  static constexpr S plausible_loss_sd = S(0.25);
  static constexpr S plausible_resistance_sd = S(0.01);
  static S log_prior(const typename Filter::State& f);

  /// Temperatures at which a search looks for R-phase, or steps of a walker, in each call.
  static constexpr int places_in_call = 4;

  /// A walker goes up to `longest_path` steps from the leader, in each call a few; not nearer to
  /// the air, where the heat that the wire loses says nothing.
  static constexpr S path_step_K = S(1);
  static constexpr int longest_path = 60;
  static constexpr S nearest_to_air_K = S(5);
  /// When walkers have become leaders this often within a few seconds, and the last one strays,
  /// too, the air is not to blame: the phases are wrong, and the search starts again.
  static constexpr S most_moves = S(3.2);
  static constexpr S moves_fade_s = S(5);

  /// Rise of the temperature in a whole heating. It takes the heat of this rise, and the latent
  /// heat of M2A; after so many times that heat a search is to end.
  static constexpr S cycle_K = S(80);
  static constexpr S cycles = S(2), cycles_in_moved_air = S(3);
  /// A wire that is this much above its air counts as cold.
  static constexpr S still_cold_K = S(10);
  /// In each of these times the likelihood of the others falls to 1/e.
  static constexpr S fades_s = S(0.1);

  static bool has_bit(std::uint8_t bits, std::size_t i) { return (bits >> i & 1U) != 0; }
  static void set_bit(std::uint8_t& bits, std::size_t i, bool value) {
    const unsigned others = bits & ~(1U << i);
    bits = static_cast<std::uint8_t>(value ? others | 1U << i : others);
  }
  static bool is_alive(const State& s, std::size_t i) { return has_bit(s.alive, i); }
  static void drop(State& s, std::size_t i) { set_bit(s.alive, i, false); }

  static Estimate<S> estimate(const State& s);
  static Estimate<S> estimate_one(const Params& p, const State& s, std::size_t i);
  static void begin_search(State& s, std::size_t to_open, const S& others_start);
  static bool searching(const State& s) {
    return s.unopened > 0 || (s.alive & (s.alive - 1U)) != 0;
  }
  static void search(const Params& p, State& s, const Measurement<S>& m, const S& dt_s);
  static void search_further(const Params& p, State& s, const Measurement<S>& m, const S& dt_s);
  static void open_further(const Params& p, State& s, const Measurement<S>& m, const S& dt_s);
  static void open(const Params& p, State& s, std::size_t i, const Measurement<S>& m);
  static std::uint8_t next_follower(const State& s);
  static void follow(const Params& p, State& s, std::size_t i, const Measurement<S>& m,
                     const S& dt_s);
  static void choose(State& s);
  /// Not inline: its estimate would lie on the stack while a filter makes a step.
  [[gnu::noinline]] static void fade(const Params& p, State& s, const Measurement<S>& m,
                                     const S& dt_s);
  static std::size_t most_usual(const State& s);
  static bool strayed(const Params& p, const State& s);
  static void set_out(State& s);
  static void walk(const Params& p, State& s, const Measurement<S>& m);
  static bool has_arrived(const State& s, const S& before_ohm);
  static void end_path(const Params& p, State& s);
  static void merge(State& s, std::size_t i);
  static bool agree(const typename Filter::State& a, const typename Filter::State& b,
                    bool also_the_loss);
};

template <class S>
void MultipleModelFilter<S>::start(const Params& p, State& s, const Measurement<S>& m,
                                   const S& ambient_K) {
  s = {};
  s.start_ambient_K = ambient_K;
  s.rest_slope = Filter::rest_slope(p, m.stress_Pa, ambient_K);
  open(p, s, 0, m);
  s.compared = m.resistance_valid;
  if (s.compared) {
    begin_search(s, hypotheses - 1, other_starts);
  }
}

template <class S>
void MultipleModelFilter<S>::advance(const Params& p, State& s, const Measurement<S>& m,
                                     const S& dt_s) {
  if (!s.compared && m.resistance_valid) {
    s.compared = true;
    begin_search(s, hypotheses - 1, other_starts);
  }
  if (searching(s) && !s.air_moved) {
    search(p, s, m, dt_s);
    return;
  }
  if (searching(s)) {
    search(p, s, m, dt_s);
  } else {
    const Heading heading = likeliest(s).kinetics.heading;
    follow(p, s, s.leader, m, dt_s);
    if (!m.resistance_valid || Filter::held(likeliest(s))) {
      s.paths = 0;  // by the next reading that counts the wire may be elsewhere
    } else if (s.paths > 0 && likeliest(s).kinetics.heading == heading) {
      walk(p, s, m);
    }
  }
  // While the wire pulls at its stop no reading decides between hypotheses: a doubt stands still.
  if (!Filter::held(likeliest(s))) {
    s.doubt_s = Filter::contradicted(likeliest(s)) ? s.doubt_s + dt_s : S(0);
    if (m.resistance_valid && S(1) < s.doubt_s) {
      s.alive = static_cast<std::uint8_t>(1U << s.leader);
      begin_search(s, hypotheses, S(0));
    } else if (m.resistance_valid && s.paths == 0 && strayed(p, s)) {
      set_out(s);
    }
  }
  s.moves -= dt_s / moves_fade_s * s.moves;
}

/// Keeps the present leader until all hypotheses are open; if `to_open` is all of them, its own
/// filter is replaced last.
template <class S>
void MultipleModelFilter<S>::begin_search(State& s, std::size_t to_open, const S& others_start) {
  s.follower = s.leader;
  s.last_opened = s.leader;
  s.unopened = static_cast<std::uint8_t>(to_open);
  s.places = 0;
  s.rest_slope_known = false;
  s.max_r_phase = S(0);
  s.others_start = others_start;
  s.doubt_s = S(0);
  s.air_moved = false;
  s.paths = 0;
  s.heat_J = S(0);
}

/// A leader that has not seen the wire at rest may have a wrong factor on the resistance.
template <class S>
bool MultipleModelFilter<S>::strayed(const Params& p, const State& s) {
  return Filter::strayed(p, likeliest(s), has_bit(s.seen_rest, s.leader) ? S(1) : unseen_rest_bias);
}

/// The leader alone goes on while two walkers look for the resistance, one after the other. What
/// still competed with it is given up: the likeliest of all contradicts the resistance.
template <class S>
void MultipleModelFilter<S>::set_out(State& s) {
  s.alive = static_cast<std::uint8_t>(1U << s.leader);
  if (s.air_moved && s.leader != s.origin) {
    s.moves += S(1);
    if (most_moves < s.moves) {
      s.moves = S(0);
      begin_search(s, hypotheses, S(0));
      return;
    }
  }
  s.origin = s.leader;
  s.air_moved = true;
  s.paths = 2;
  s.places = 0;
  s.arrived = 0;
}

/// The first path leads to the cold, the second one to the heat. Its first call only copies the
/// leader.
template <class S>
void MultipleModelFilter<S>::walk(const Params& p, State& s, const Measurement<S>& m) {
  const bool cools = s.paths == 2;
  const std::size_t walker = (s.leader + s.paths) % hypotheses;
  typename Filter::State& f = s.filter[walker];
  if (s.places == 0) {
    f = likeliest(s);
    s.first_missing_ohm = s.missing_ohm = f.bias * f.model_ohm;
    ++s.places;
    return;
  }
  for (int i = 0; i < places_in_call; ++i) {
    const S T = f.kinetics.drive.temperature_K + (cools ? -path_step_K : path_step_K);
    if (s.places > longest_path || T < f.ambient_K + nearest_to_air_K || p.tuning.hottest_K < T) {
      end_path(p, s);
      return;
    }
    Filter::lead(p, f, T);
    ++s.places;
    const S before_ohm = s.missing_ohm;
    s.missing_ohm = m.resistance_ohm - Filter::expected(p, f).ohm;
    if (has_arrived(s, before_ohm)) {
      Filter::go_on(p, f, m.power_W, cools ? Heading::cooling : Heading::heating);
      set_bit(s.arrived, walker, true);
      end_path(p, s);
      return;
    }
  }
}

/// Where nothing is missing any more; or where more begins to be missing again, after half of it
/// was found.
template <class S>
bool MultipleModelFilter<S>::has_arrived(const State& s, const S& before_ohm) {
  const S sign = s.first_missing_ohm < S(0) ? S(-1) : S(1);
  const S now = sign * s.missing_ohm;
  const S before = sign * before_ohm;
  return now < S(0) || (before < now && before < S(0.5) * sign * s.first_missing_ohm);
}

/// After the last path the hypotheses that have arrived compete with the leader.
template <class S>
void MultipleModelFilter<S>::end_path(const Params& p, State& s) {
  s.places = 0;
  if (--s.paths > 0) {
    return;
  }
  s.filter[s.leader].bias = S(0);
  s.heat_J = S(0);
  s.alive = static_cast<std::uint8_t>(s.alive | s.arrived);
  for (std::size_t i = 0; i < hypotheses; ++i) {
    if (!is_alive(s, i)) {
      continue;
    }
    s.log_likelihood[i] = s.log_weight[i] = S(0);
    s.missed[i] = {S(0), S(0)};
    if (i != s.leader) {
      set_bit(s.seen_rest, i, has_bit(s.seen_rest, s.leader));
      s.last[i] = estimate_one(p, s, i);
    }
  }
}

/// A step of the leader, then a part of the opening or a step of the filter whose turn it is. A
/// step in which the leader reverses its heading is so expensive that the others wait.
template <class S>
void MultipleModelFilter<S>::search(const Params& p, State& s, const Measurement<S>& m,
                                    const S& dt_s) {
  for (std::size_t i = 0; i < hypotheses; ++i) {
    if (is_alive(s, i) && i != s.leader) {
      s.missed[i].time_s += dt_s;
      s.missed[i].energy_J += m.power_W * dt_s;
    }
  }
  const Heading heading = likeliest(s).kinetics.heading;
  follow(p, s, s.leader, m, dt_s);
  if (likeliest(s).kinetics.heading == heading) {
    search_further(p, s, m, dt_s);
  }
  if (s.unopened == 0) {
    choose(s);
    fade(p, s, m, dt_s);
  }
}

template <class S>
void MultipleModelFilter<S>::search_further(const Params& p, State& s, const Measurement<S>& m,
                                            const S& dt_s) {
  if (s.unopened > 0 && m.resistance_valid) {
    open_further(p, s, m, dt_s);
    return;
  }
  const std::uint8_t next = next_follower(s);
  if (next != s.leader) {
    s.follower = next;
    follow(p, s, next, m, S(0));
  }
}

/// The next hypothesis whose turn it is; the leader if there is no other.
template <class S>
std::uint8_t MultipleModelFilter<S>::next_follower(const State& s) {
  for (std::size_t step = 1; step <= hypotheses; ++step) {
    const std::size_t i = (s.follower + step) % hypotheses;
    if (i != s.leader && is_alive(s, i)) {
      return static_cast<std::uint8_t>(i);
    }
  }
  return s.leader;
}

/// The opening uses the leader's filtered stress, because the measurement's may be invalid.
template <class S>
void MultipleModelFilter<S>::open_further(const Params& p, State& s, const Measurement<S>& m,
                                          const S& dt_s) {
  Measurement<S> now = m;
  now.stress_Pa = likeliest(s).load_Pa;
  const auto i = static_cast<std::uint8_t>((s.last_opened + 1U) % hypotheses);
  if (s.places < Starts::places) {
    const S r = Starts::most_r_phase(p, now.stress_Pa, s.places, places_in_call);
    s.max_r_phase = s.max_r_phase < r ? r : s.max_r_phase;
    s.places = static_cast<std::uint8_t>(s.places + places_in_call);
  } else if (i == 0 && !s.rest_slope_known) {
    s.rest_slope = Filter::rest_slope(p, now.stress_Pa, s.start_ambient_K);
    s.rest_slope_known = true;
  } else {
    open(p, s, i, now);
    if (i == 0) {
      // The others agree with the reading; a wire at rest would lead until its first step.
      s.log_likelihood[i] += Filter::log_likelihood(p, s.filter[i], now, dt_s);
      s.log_weight[i] = s.log_likelihood[i];
    }
    s.last_opened = i;
    --s.unopened;
  }
}

template <class S>
void MultipleModelFilter<S>::open(const Params& p, State& s, std::size_t i,
                                  const Measurement<S>& m) {
  if (i == 0) {
    Filter::start_at_rest(p, s.filter[i], m, s.start_ambient_K, s.rest_slope);
  } else {
    Starts::start(p, s.filter[i], i, m, s.start_ambient_K, s.max_r_phase);
  }
  set_bit(s.alive, i, true);
  set_bit(s.seen_rest, i, i == 0);
  s.last[i] = estimate_one(p, s, i);
  s.missed[i] = {S(0), S(0)};
  s.log_likelihood[i] = i == 0 ? S(0) : s.others_start;
  s.log_weight[i] = s.log_likelihood[i];
}

/// Makes a step of a filter over all that it has missed and the present sample, and counts its
/// innovation.
template <class S>
void MultipleModelFilter<S>::follow(const Params& p, State& s, std::size_t i,
                                    const Measurement<S>& m, const S& dt_s) {
  typename Filter::State& f = s.filter[i];
  Missed& missed = s.missed[i];
  Measurement<S> told = m;
  S told_s = dt_s;
  if (S(0) < missed.time_s) {
    told_s = missed.time_s + dt_s;
    told.power_W = (missed.energy_J + m.power_W * dt_s) / told_s;
    missed = {S(0), S(0)};
  }
  Filter::advance(p, f, told, told_s);
  // The logarithm of the variance is left out: the filters treat the resistance model's coloured
  // error as white noise, so that term alone would decide, for the most confident filter.
  if (m.resistance_valid && searching(s) && !Filter::held(f)) {
    s.log_likelihood[i] -= S(0.5) * f.innovation_ohm * f.innovation_ohm / f.innovation_variance;
    s.log_weight[i] = s.log_likelihood[i] + (s.air_moved ? S(0) : log_prior(f));
  }
  s.last[i] = estimate_one(p, s, i);
}

template <class S>
S MultipleModelFilter<S>::log_prior(const typename Filter::State& f) {
  const S ambient = (f.ambient_K - f.start_ambient_K) / plausible_ambient_sd_K;
  const S loss = (f.loss - S(1)) / plausible_loss_sd;
  const S resistance = (f.resistance - S(1)) / plausible_resistance_sd;
  return S(-0.5) * (ambient * ambient + loss * loss + resistance * resistance);
}

/// Makes the most likely hypothesis the leader; drops those that have become unlikely.
template <class S>
void MultipleModelFilter<S>::choose(State& s) {
  std::size_t best = s.leader;
  for (std::size_t i = 0; i < hypotheses; ++i) {
    best = is_alive(s, i) && s.log_weight[best] < s.log_weight[i] ? i : best;
  }
  s.leader = static_cast<std::uint8_t>(best);
  const S max = s.log_weight[best];
  for (std::size_t i = 0; i < hypotheses; ++i) {
    s.log_likelihood[i] -= max;
    s.log_weight[i] -= max;
    if (i != best && !(min_log_weight < s.log_weight[i])) {
      drop(s, i);
    }
  }
  merge(s, s.follower);
}

/// Drops the less likely one of two hypotheses that agree. Filter i has just made a step.
template <class S>
void MultipleModelFilter<S>::merge(State& s, std::size_t i) {
  for (std::size_t j = 0; j < hypotheses && is_alive(s, i); ++j) {
    if (j != i && is_alive(s, j) && agree(s.filter[i], s.filter[j], s.air_moved)) {
      drop(s, j == s.leader || s.log_weight[i] < s.log_weight[j] ? i : j);
    }
  }
}

/// Ends a search that the resistance does not decide. A held wire may fit two hypotheses equally
/// well for ever. The heat counts from the beginning of the search, also while the hypotheses
/// agree. Then the others lose their weight little by little, since a control loop follows the
/// estimate, until the strains agree within agreed_sd.
template <class S>
void MultipleModelFilter<S>::fade(const Params& p, State& s, const Measurement<S>& m,
                                  const S& dt_s) {
  if (!m.resistance_valid || !searching(s)) {
    return;
  }
  // One wrong reading of the power must not end a search.
  const ThermalBody<S>& body = p.model.body;
  const S hot_W = body.loss_W(cycle_K);
  const S counted_W = (m.power_W < hot_W ? m.power_W : hot_W) - body.loss_W(still_cold_K);
  s.heat_J += S(0) < counted_W ? counted_W * dt_s : S(0);
  const S cycle_J = body.capacity_J_K * cycle_K + body.latent_m2a_J;
  if (s.heat_J < (s.air_moved ? cycles_in_moved_air : cycles) * cycle_J ||
      estimate(s).health == Health::good) {
    return;
  }
  const std::size_t kept = s.air_moved ? most_usual(s) : s.leader;
  for (std::size_t i = 0; i < hypotheses; ++i) {
    if (i != kept) {
      s.log_likelihood[i] -= dt_s / fades_s;
      s.log_weight[i] -= dt_s / fades_s;
    }
  }
}

/// Where the air has moved log_weight knows nothing of the loss. Of hypotheses between which the
/// resistance does not decide the one counts whose loss is nearest to the calibrated one: ½ ln²
/// (loss)/0.7², with (loss - 1)²/loss for ln².
template <class S>
std::size_t MultipleModelFilter<S>::most_usual(const State& s) {
  const auto weight = [&](std::size_t i) {
    const S loss = s.filter[i].loss;
    return s.log_weight[i] - (loss + S(1) / loss - S(2));
  };
  std::size_t best = s.leader;
  for (std::size_t i = 0; i < hypotheses; ++i) {
    best = is_alive(s, i) && weight(best) < weight(i) ? i : best;
  }
  return best;
}

template <class S>
bool MultipleModelFilter<S>::agree(const typename Filter::State& a, const typename Filter::State& b,
                                   bool also_the_loss) {
  const auto near = [](const S& x, const S& y, const S& limit) {
    return x - y < limit && y - x < limit;
  };
  return near(a.kinetics.martensite, b.kinetics.martensite, S(0.08)) &&
         near(a.kinetics.r_phase, b.kinetics.r_phase, S(0.08)) &&
         near(a.kinetics.drive.temperature_K, b.kinetics.drive.temperature_K, S(4)) &&
         (!also_the_loss || near(a.loss, b.loss, S(0.2)));
}

template <class S>
Estimate<S> MultipleModelFilter<S>::estimate_one(const Params& p, const State& s, std::size_t i) {
  using std::sqrt;
  Estimate<S> e = Filter::estimate(p, s.filter[i]);
  if (!has_bit(s.seen_rest, i)) {
    e.strain_sd = sqrt(e.strain_sd * e.strain_sd + unseen_rest_sd * unseen_rest_sd);
  }
  return e;
}

template <class S>
Estimate<S> MultipleModelFilter<S>::estimate(const State& s) {
  using std::exp;
  using std::sqrt;
  if (!searching(s)) {
    return s.last[s.leader];
  }
  if (s.unopened > 0) {
    Estimate<S> unsure = s.last[s.leader];
    unsure.strain_sd = sqrt(unsure.strain_sd * unsure.strain_sd + unknown_sd * unknown_sd);
    unsure.health = Health::searching;
    return unsure;
  }
  Estimate<S> mean{};
  S weights = S(0);
  S square = S(0);
  S scatter = S(0);
  for (std::size_t i = 0; i < hypotheses; ++i) {
    if (!is_alive(s, i)) {
      continue;
    }
    const S w = i == s.leader ? S(1) : exp(s.log_weight[i]);  // likelihood relative to the leader's
    const Estimate<S>& e = s.last[i];
    weights += w;
    mean.strain += w * e.strain;
    square += w * (e.strain * e.strain + e.strain_sd * e.strain_sd);
    scatter += w * e.strain * e.strain;
    mean.temperature_K += w * e.temperature_K;
    mean.martensite += w * e.martensite;
    mean.r_phase += w * e.r_phase;
    mean.resistance_model_ohm += w * e.resistance_model_ohm;
  }
  mean.strain /= weights;
  const S variance = square / weights - mean.strain * mean.strain;
  mean.strain_sd = sqrt(variance < S(0) ? S(0) : variance);
  mean.temperature_K /= weights;
  mean.martensite /= weights;
  mean.r_phase /= weights;
  mean.resistance_model_ohm /= weights;
  scatter = scatter / weights - mean.strain * mean.strain;
  mean.health = scatter < agreed_sd * agreed_sd ? Health::good : Health::searching;
  return mean;
}

}  // namespace smaservo
