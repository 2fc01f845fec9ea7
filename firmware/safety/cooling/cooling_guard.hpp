#pragma once
// Guard against less cooling than the wire's file says, by a clock: how long the wire takes to cool
// from hot to where its resistance begins to rise.
//
// A wire held hot gives off what it gets, whatever cools it, and austenite's resistance hardly
// tells its temperature; the observer explains the little that it sees by air, loss or drift. The
// time of cooling tells: with half the cooling the wire is hotter and cools half as fast, so that
// it takes twice to four times as long until R-phase or martensite raise the resistance. For each
// of some shares of the file's cooling the guard integrates how hot the wire would be; when the
// resistance rises, only those shares are possible whose temperature is then that of the
// transformation. Every motion that cools the wire is such a test. A wire that stays hot without
// one is probed: its power is cut until the resistance rises.
//
//             less than 30 % is left                a probe is wanted (wants_probe),
//             of martensite and R-phase,            or the cooling has changed (doubt, settle),
//             or of martensite and a quarter        or the resistance says that the wire
//             of the R-phase (seems_hot)            is too hot (hotter_than_told)
//     cold -----------------------------> hot -----------------------------------> probing
//      |                                   |                                          |
//      | <---------------------------------+------------------------------------------+
//      |    the resistance rises: judge() takes the time of cooling for a verdict
//      |    the observer has the wire cold, by martensite: nothing is told, but see follow()
//      |    no resistance can be read for 30 ms, or the loop stood still: nothing is told
//      |    probing for 16 time constants without a rise: the verdict is weak
//      |
//      + off until the wire has the air's temperature: all is forgotten, since a fan may have
//      stopped
//
// The resistance alone does not tell the observer's R-phase from heat. A hot wire that is cooled
// less than its file says has a resistance that is 1 to 2 % higher; a reading that is off may add
// as much. An observer explains this by 30 to 40 % of R-phase, cold at the same power, and the
// guard would leave such a wire too hot without end. Martensite raises the resistance by more than
// any heat. So R-phase counts by a quarter only, and a wire that may be hot is followed as a hot
// one: the heat balances go on, and when the power has been too much for the least cooling that is
// possible, the wire is probed. A wire that really is R-phase then answers at once, its cooling is
// confirmed, and the power goes on. Within a second after a test R-phase is believed, since the
// test has shown it. When the observer, too, has the wire hot, the observation begins anew: the
// heat balances have no latent heat, and are too hot by up to 40 K after a transformation.
//
// The same heat also raises the resistance of a wire whose verdict stands. If it rises although by
// the file's cooling the wire is too hot to transform, and so far that the wire would be above its
// limit, it is probed again. Each such probe doubles the time until the next one, up to 16 s.
//
// The verdict says what the last test told, and when a wire that is hot is probed again:
//
//     none        at once where the wire could be too hot with the least cooling that is possible
//     confirmed   where it is pressed against its limit, 1, 2, 4 ... 20 s after the last test
//     weak        each 5 s, so that a fan that runs again is found; 1, 2, 4 s after a fall
//     overheated  the same; until the wire is hot again a fault says that it was too hot
//
// Where a test finds less cooling than the one before, by 0.05 or more, the next one comes after
// 1 s, then after 2, 4 ... s again: what has begun to fall mostly falls further. A test made by a
// motion or an alarm before half of this time has passed does not double it. The verdict is weak
// where less than 0.7 of the file's cooling is left, and where less than 0.9 is left with which the
// wire was too hot. It is overheated where the wire was too hot with less than 0.7: or 0.85, after
// three tests that told too little, or 0.9, if the verdict was weak before.
//
// A wire whose cooling is confirmed may be held for any time while power, load and resistance stay
// as they are, since the cooling mostly does, too. ResistanceWatch sees where they do not. A wire
// is pressed while the temperature limit acts, and where it is close to its limit and wholly
// austenite: there are loads under which its resistance does not move when it gets hotter. A strain
// that can be reached leaves some martensite, whose loss the loop sees and answers with less power;
// there a probe would cost 10 to 20 % of the stroke. So it is probed only where the power has
// fallen far.
//
// A wire whose cooling is confirmed may stay austenite although, with the file's cooling, it would
// be more than 20 K below where it begins to transform. Its cooling has then fallen, and the
// verdict becomes none.
//
// Where a number below has no other source it was chosen on simulated wires, by the temperatures of
// `host-sim evaluate --closed-loop --random-from 50000` and by held strains (commits e0eb91cd and
// 0e1184e1 have the tables); what concerns R-phase, and the rise of the resistance,
// on 10 000 of them from seed 7000000 on. firmware/README.md says how well it holds on other seeds.

#include "firmware/safety/cooling/cooling_shares.hpp"
#include "firmware/safety/cooling/resistance_watch.hpp"

namespace smaservo {

/// All zero: nothing has been seen.
template <class S>
struct CoolingGuard {
  enum class Phase : std::uint8_t {
    cold,  ///< has transformed back, or where this cannot be told
    hot,   ///< transformed, or cooling from there
    probing
  };
  enum class Verdict : std::uint8_t { none, confirmed, weak, overheated };

  Phase phase;
  bool doubted;              ///< the wire is followed as a hot one though the observer has it cold
  CoolingShares<S> shares;   ///< since the wire became hot
  ResistanceWatch<S> watch;  ///< likewise

  /// Results of the tests.
  struct Told {
    Verdict verdict;
    std::uint8_t share;   ///< index of the greatest share that is not above `cooling`
    S cooling;            ///< share of the file's, 0.3 to 1
    std::uint8_t least;   ///< index of the least share that is still possible, where none
    std::uint8_t doubts;  ///< tests in a row that told too little
    S lease_s;  ///< time from the last test to the next while pressed; if weak, at most again_s
    S trust_s;  ///< time after a test in which a rise of the resistance is no reason for one
    S since_s;  ///< time since the last test, up to 1000
  } told;

  S probed_s;     ///< time for which the probe has lasted
  S blind_s;      ///< time for which no resistance has been valid
  S unlimited_s;  ///< time for which the temperature limit has not acted, up to 1000

  /// Whether the power is to be cut.
  bool probing() const { return phase == Phase::probing; }
  bool weak() const { return told.verdict == Verdict::weak || overheated(); }
  /// Whether the last test says that the wire was too hot.
  bool overheated() const { return told.verdict == Verdict::overheated; }
  /// Cooling as a share of the file's; 1 where it is not known to be weaker.
  S known() const { return weak() ? told.cooling : S(1); }
  /// Temperature that the power is to be limited by; 0: not known.
  S limit_K() const {
    return weak() && phase != Phase::cold ? shares.temperature_K[told.share] : S(0);
  }

  /// Sets the state after a test that confirmed the file's cooling. For simulations in which this
  /// cooling is known, and in which probes would only disturb.
  void confirm() {
    told.verdict = Verdict::confirmed;
    told.cooling = S(1);
    told.lease_s = last_lease_s;
    told.since_s = watch.held_K = S(0);
  }
  /// To be called after the loop stood still: a cooling whose beginning was not observed has no
  /// result, and a confirmed cooling may have changed meanwhile.
  void miss() {
    phase = Phase::cold;
    told.verdict = weak() ? told.verdict : Verdict::none;
  }
  /// Cost: 140 operations while the wire is hot, five divisions among them; else next to none.
  void advance(const MonitorInputs<S>& seen);

 private:
  using Shares = CoolingShares<S>;

  /// Temperatures at which A2R and A2M begin under the load.
  struct Starts {
    S a2r_K, a2m_K;
  };

  // The transitions. Of martensite and R-phase together a wire has less than the first share when
  // it becomes hot, and more than the second where the resistance has told nothing.
  static constexpr S becomes_hot = S(0.3), is_cold = S(0.6);
  /// What R-phase counts in seems_hot(). It raises the resistance by half of what martensite does,
  /// and the observer explains up to 2.5 % by a drift besides, so that some half of that may be
  /// heat, or a reading that is off.
  static constexpr S r_phase_share = S(0.25);
  /// For believes_s(). Of a wire that is cooled less the power is limited only while it is followed
  /// as a hot one; but `overheated` must have tripped before.
  static constexpr S believed_s = S(1), believed_weak_s = S(0.05);
  /// If A2M begins this far above A2R, the resistance of a cooling wire rises too little to be
  /// seen.
  static constexpr S a2m_before_a2r_K = S(25);
  static constexpr S max_blind_s = S(0.03);
  /// Time constants of the wire in still air. With 0.3 of the cooling they are five: a wire then is
  /// within 1 % of the air's temperature, whatever it had.
  static constexpr S max_probe = S(16);
  /// Times are counted up to this one; all times that are compared are shorter.
  static constexpr S max_s = S(1000);

  // The judgement.
  /// Distance below the beginning of A2R or A2M at which the resistance has risen enough; in
  /// simulated wires within 7 K.
  static constexpr S below_start_K = S(6);
  /// Least spread of the shares' temperatures for a result, because the temperature of the
  /// transformation is known only within 7 K.
  static constexpr S told_apart_K = S(20);
  /// A test is good if the spread of the temperatures, or the cooling that it finds, is above
  /// these. Of a wire that is known to be cooled less, only the spread counts: its test begins with
  /// an uncertain temperature, and may find too much.
  static constexpr S good_K = S(50), good = S(0.9);
  /// A short test found up to 0.2 of the share too much. So a result that is not good needs more,
  /// and three of them in a row count as one that is good.
  static constexpr S error = S(0.2);
  static constexpr std::uint8_t max_doubts = 3;
  /// Least cooling with which a verdict is not weak; if the wire was too hot, always enough_again.
  static constexpr S enough = S(0.7), enough_in_doubt = S(0.85), enough_again = S(0.9);

  // The temperatures that lead to a probe.
  /// Excess over the limit that the random scenarios count as too hot.
  static constexpr S allowed_K = S(3);
  /// A wire that by its file's cooling is this far below the beginning of the transformation should
  /// have transformed by stays_austenite_share: 7 K by which the beginning is known, and some 10 K
  /// for the latent heat of that share, which the heat balances lack.
  static constexpr S should_rise_K = S(20);
  /// Most of martensite and R-phase that an austenite wire seems to have.
  static constexpr S stays_austenite_share = S(0.2);
  /// Share of limits.hot_spot_K that a freely hanging wire has.
  static constexpr S hot_spot = S(0.33);
  /// Distance of the mean temperature from its limit within which a doubt starts a probe at once.
  static constexpr S close_K = S(20);
  static constexpr S pressed_K = S(12);  ///< distance within which a wire can be pressed
  static constexpr S pressed_s = S(0.5), pressed_cold = S(0.05);
  static constexpr S first_lease_s = S(1), last_lease_s = S(20), again_s = S(5);
  /// Loss of cooling from one test to the next that sets the lease to first_lease_s; good tests of
  /// an unchanged wire scatter by 0.03.
  static constexpr S falls_by = S(0.05);
  /// A rise of the resistance counts as heat where by the file's cooling the wire is this far above
  /// the beginning of the transformation. With up to 1.3 of the file's cooling it truly is above
  /// it.
  static constexpr S above_start_K = S(12);
  /// It leads to a test where the mean is this far above its limit: with the limits of the other
  /// guards a wire is held at the limit itself, and a few kelvins above it by their noise.
  static constexpr S beyond_K = S(8);
  /// After a test the resistance first has to be read again. Each such test doubles the time.
  static constexpr S first_trust_s = S(0.05), next_trust_s = S(0.5), last_trust_s = S(16);

  bool confirmed() const { return told.verdict == Verdict::confirmed; }
  S whole_K() const { return shares.temperature_K[Shares::whole]; }
  static S max_K(const MonitorInputs<S>& seen) {
    return seen.prepared.settings.limits.temperature_K;
  }
  /// The temperature of the mean of a wire whose hottest place is at the limit.
  static S mean_max_K(const MonitorInputs<S>& seen) {
    return max_K(seen) - seen.prepared.settings.limits.hot_spot_K;
  }
  static bool too_hot(const MonitorInputs<S>& seen, const S& wire_K) {
    return max_K(seen) + allowed_K < wire_K + hot_spot * seen.prepared.settings.limits.hot_spot_K;
  }
  /// Whether the resistance does not exclude that the wire is austenite.
  static bool seems_hot(const MonitorInputs<S>& seen) {
    return seen.estimate.martensite + r_phase_share * seen.estimate.r_phase < becomes_hot;
  }
  /// Time after a test in which R-phase is believed, since it has raised the resistance.
  S believes_s() const {
    return !(S(0) < told.lease_s) ? S(0) : weak() ? believed_weak_s : believed_s;
  }
  static Starts starts(const MonitorInputs<S>& seen);

  void count(const MonitorInputs<S>& seen);
  bool begin(const MonitorInputs<S>& seen, const Starts& start);
  void follow(const MonitorInputs<S>& seen, const Starts& start);
  void end(Verdict verdict);
  void end_without_result();
  void renew_lease(bool falls, bool less);
  void judge(const MonitorInputs<S>& seen, const S& transforms_K);
  void doubt(const MonitorInputs<S>& seen);
  void settle(const MonitorInputs<S>& seen);
  bool stays_austenite(const MonitorInputs<S>& seen, const S& starts_K) const;
  bool is_pressed(const MonitorInputs<S>& seen) const;
  bool wants_probe(const MonitorInputs<S>& seen) const;
  bool hotter_than_told(const MonitorInputs<S>& seen, const S& starts_K);
};

template <class S>
void CoolingGuard<S>::advance(const MonitorInputs<S>& seen) {
  count(seen);
  if (seen.off() && seen.cold()) {
    *this = CoolingGuard{};
    return;
  }
  const bool austenite = seen.estimate.martensite + seen.estimate.r_phase < becomes_hot;
  const bool begins = phase == Phase::cold
                          ? austenite || (seems_hot(seen) && believes_s() < told.since_s)
                          : phase == Phase::hot && doubted && austenite;
  if (phase == Phase::cold && !begins) {
    return;
  }
  const Starts start = starts(seen);
  const bool begun = begins && begin(seen, start);
  if (begun || phase != Phase::cold) {
    follow(seen, start);
  }
}

template <class S>
void CoolingGuard<S>::count(const MonitorInputs<S>& seen) {
  told.since_s = told.since_s < max_s ? told.since_s + seen.dt_s : told.since_s;
  const S longer_s = unlimited_s < max_s ? unlimited_s + seen.dt_s : unlimited_s;
  unlimited_s = seen.last.limited_by(LimitReason::temperature) ? S(0) : longer_s;
}

/// T_s = c_0 + c_1 σ + c_2 σ²
template <class S>
auto CoolingGuard<S>::starts(const MonitorInputs<S>& seen) -> Starts {
  const Pair<S>(&c)[3] = seen.prepared.observer.model.kinetics.a2m_a2r.start_K;
  const Pair<S> sigma(seen.filter.stress_Pa);
  const Pair<S> start_K = c[0] + sigma * (c[1] + sigma * c[2]);
  return {start_K.second(), start_K.first()};
}

/// Begins to observe a wire that has become hot, unless a test of it could have no result. Returns
/// whether it has begun.
template <class S>
bool CoolingGuard<S>::begin(const MonitorInputs<S>& seen, const Starts& start) {
  if (start.a2r_K + a2m_before_a2r_K < start.a2m_K) {
    return false;
  }
  phase = Phase::hot;
  doubted = !(seen.estimate.martensite + seen.estimate.r_phase < becomes_hot);
  shares.start(seen.estimate.temperature_K);
  watch.start(seen.estimate.temperature_K);
  told.verdict = overheated() ? Verdict::weak : told.verdict;
  probed_s = blind_s = S(0);
  return true;
}

/// Makes one step with a hot wire.
template <class S>
void CoolingGuard<S>::follow(const MonitorInputs<S>& seen, const Starts& start) {
  shares.integrate(seen);
  if (!seen.measurement.resistance_valid) {
    // The resistance may rise unseen.
    blind_s += seen.dt_s;
    phase = blind_s < max_blind_s ? phase : Phase::cold;
    return;
  }
  blind_s = S(0);
  watch.take(seen);
  const S starts_K = start.a2r_K < start.a2m_K ? start.a2m_K : start.a2r_K;
  if (watch.risen()) {
    judge(seen, starts_K - below_start_K);
    return;
  }
  const ThermalBody<S>& body = seen.prepared.observer.model.body;
  probed_s = probing() ? probed_s + seen.dt_s : S(0);
  if (max_probe * body.capacity_J_K < probed_s * body.loss_W_K) {
    // The wire stays hot without power, or the reading is not its resistance.
    told.share = 0;
    told.cooling = Shares::shares[0];
    end(Verdict::weak);
    return;
  }
  if (is_cold < seen.estimate.martensite + seen.estimate.r_phase && !seems_hot(seen)) {
    // Where A2M comes first the resistance may not rise, but the wire has become cold in time.
    const bool in_time = probing() && start.a2r_K < start.a2m_K && !weak();
    end(in_time ? Verdict::confirmed : told.verdict);
    return;
  }
  if (stays_austenite(seen, starts_K)) {
    told.verdict = Verdict::none;
    told.least = 0;
  }
  const auto found = watch.look(seen, whole_K(), told.since_s);
  if (found == ResistanceWatch<S>::Finding::moved) {
    doubt(seen);
  } else if (found == ResistanceWatch<S>::Finding::settled) {
    settle(seen);
  }
  const bool hotter = hotter_than_told(seen, starts_K);
  if (!probing() && (hotter || wants_probe(seen))) {
    phase = Phase::probing;
    told.trust_s =
        hotter ? clamp(told.trust_s + told.trust_s, next_trust_s, last_trust_s) : told.trust_s;
  }
}

/// Whether the resistance has risen as if the wire were too hot, and no test has been made because
/// of it lately.
template <class S>
bool CoolingGuard<S>::hotter_than_told(const MonitorInputs<S>& seen, const S& starts_K) {
  const S rise_K = watch.hotter_K(seen, whole_K());
  return S(0) < rise_K && starts_K + above_start_K < whole_K() &&
         mean_max_K(seen) + beyond_K < whole_K() + rise_K &&
         told.trust_s + first_trust_s < told.since_s;
}

/// Ends the observation of a cooling with this verdict.
template <class S>
void CoolingGuard<S>::end(Verdict verdict) {
  phase = Phase::cold;
  told.verdict = verdict;
  told.since_s = S(0);
}

/// Whether the file's cooling, which the last test has confirmed, would have transformed the wire,
/// and it stays austenite: it is cooled less by now.
template <class S>
bool CoolingGuard<S>::stays_austenite(const MonitorInputs<S>& seen, const S& starts_K) const {
  return confirmed() && !probing() && whole_K() < starts_K - should_rise_K &&
         seen.estimate.martensite + seen.estimate.r_phase < stays_austenite_share;
}

template <class S>
bool CoolingGuard<S>::is_pressed(const MonitorInputs<S>& seen) const {
  const S cold = seen.estimate.martensite + seen.estimate.r_phase;
  const S wire_K =
      whole_K() < seen.estimate.temperature_K ? seen.estimate.temperature_K : whole_K();
  return mean_max_K(seen) - pressed_K < wire_K && (unlimited_s < pressed_s || cold < pressed_cold);
}

template <class S>
bool CoolingGuard<S>::wants_probe(const MonitorInputs<S>& seen) const {
  if (weak()) {
    const bool renewed = S(0) < told.lease_s && told.lease_s < again_s;
    return (renewed ? told.lease_s : again_s) < told.since_s;
  }
  if (confirmed()) {
    return told.lease_s < told.since_s && is_pressed(seen);
  }
  return too_hot(seen, shares.temperature_K[told.least]);
}

template <class S>
void CoolingGuard<S>::end_without_result() {
  // A wire that is probed as soon as it is hot has no result; it has to stay hot before the next.
  told.since_s = probing() && weak() ? S(0) : told.since_s;
  phase = Phase::cold;
}

/// `falls`: the test has found less cooling than the one before; `less`: the verdict will be weak.
template <class S>
void CoolingGuard<S>::renew_lease(bool falls, bool less) {
  const bool early = told.since_s + told.since_s < told.lease_s;
  if (falls) {
    told.lease_s = first_lease_s;
  } else if (less && !weak()) {
    told.lease_s = told.lease_s < again_s ? again_s : told.lease_s;
  } else if (!early) {
    told.lease_s = clamp(told.lease_s + told.lease_s, first_lease_s, last_lease_s);
  }
}

/// To be called when the resistance has risen, so that the wire has the temperature at which it
/// transforms. If the wire was hot for too short a time, all shares are possible and there is no
/// verdict.
template <class S>
void CoolingGuard<S>::judge(const MonitorInputs<S>& seen, const S& transforms_K) {
  if (shares.spread_K() < told_apart_K) {
    end_without_result();
    return;
  }
  const typename Shares::Match match = shares.match(transforms_K);
  const bool is_good = (good < match.cooling && !weak()) || good_K < shares.spread_K();
  told.doubts = is_good ? std::uint8_t{0} : static_cast<std::uint8_t>(told.doubts + 1U);
  const bool decided = is_good || max_doubts <= told.doubts;
  const bool falls = match.cooling < told.cooling - falls_by;
  if (decided || !weak() || match.cooling < told.cooling) {
    told.cooling = match.cooling;
    told.share = match.share;
  }
  const S needed = weak() ? enough_again : decided && !is_good ? enough_in_doubt : enough;
  const bool far_less = match.cooling < needed;
  const bool was_too_hot = too_hot(seen, match.peak_K);
  const bool less = far_less || (match.cooling < enough_again && was_too_hot);
  told.doubts = decided ? std::uint8_t{0} : told.doubts;
  watch.lowest = S(0);
  renew_lease(falls, less);
  // Smaller shares also remain possible, within the error of a short test.
  told.least = 0;
  while (!less && told.least < match.share &&
         Shares::shares[told.least + 1U] < match.cooling - error) {
    ++told.least;
  }
  const Verdict too_little = far_less && was_too_hot ? Verdict::overheated : Verdict::weak;
  const Verdict undecided = weak() ? Verdict::weak : Verdict::none;
  end(less ? too_little : decided ? Verdict::confirmed : undecided);
}

/// To be called when the cooling has changed: all shares are possible, from the present
/// temperature.
template <class S>
void CoolingGuard<S>::doubt(const MonitorInputs<S>& seen) {
  if (!confirmed() && !weak()) {
    return;
  }
  const S T = shares.temperature_K[weak() ? told.share : Shares::whole];
  phase = weak() || mean_max_K(seen) - close_K < T ? Phase::probing : Phase::hot;
  told.verdict = weak() ? told.verdict : Verdict::none;
  told.least = 0;
  told.lease_s = S(0);
  shares.start(T);
  watch.forget();
}

/// To be called when the wire is held at another temperature than before. With less power under the
/// same load it is colder, but has stayed austenite; or it is as hot as it was, and is cooled less.
template <class S>
void CoolingGuard<S>::settle(const MonitorInputs<S>& seen) {
  const bool fallen = watch.settle(seen, whole_K());
  if (fallen && confirmed() && too_hot(seen, shares.temperature_K[0])) {
    told.verdict = Verdict::none;
    told.least = 0;
    phase = Phase::probing;
  }
}

}  // namespace smaservo
