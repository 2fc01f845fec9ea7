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
// transformation. Every motion that cools the wire is such a test. A wire that is held hot without
// one gets a test as soon as it could be too hot: its power is cut until the resistance rises.
//
// Once the file's cooling is confirmed the wire may be held for any time: while power, load and
// resistance stay as they are, the cooling mostly does, too. A resistance that moves by itself
// takes the confirmation back; so does time, where the wire is pressed against its limit, since
// there are loads under which the resistance of a wire that gets hotter does not move. It is
// pressed while the temperature limit acts, and where it is close to it and wholly austenite. A
// strain that can be reached leaves some martensite, whose loss the loop sees and answers with less
// power: there a test would cost 10 to 20 % of the stroke. But where the power has fallen far, and
// neither load nor phases have changed, cooling may have fallen with it: that is tested.

#include <array>
#include <cstdint>

#include "firmware/safety/monitor/hot_resistance.hpp"

namespace smaservo {

/// All zero: nothing has been seen.
template <class S>
struct CoolingGuard {
  static constexpr std::size_t count = 6;
  /// The shares of the file's cooling that are told apart.
  static constexpr std::array<S, count> shares{S(0.3), S(0.4), S(0.5), S(0.65), S(0.8), S(1)};
  static constexpr std::size_t whole = count - 1;

  std::array<S, count> temperature_K;  ///< of the wire with each share
  std::array<S, count> peak_K;         ///< since it became hot
  bool hot;         ///< transformed, or cooling from there; the fields below count from its begin
  bool confirmed;   ///< by the last test: the file's cooling
  bool weak;        ///< by the last test: less
  bool overheated;  ///< the last test says that the wire was too hot
  bool probing;     ///< the power is to be cut
  std::uint8_t least;  ///< index of the least share that is still possible, unless confirmed
  std::uint8_t share;  ///< by the last test, index of the next smaller share
  S cooling;           ///< by the last test, 0.3 to 1
  S resistance;        ///< as a share of austenite's under this load, filtered; 0: none yet
  S noise;             ///< mean distance of the readings from it
  S min;               ///< lowest since the wire became hot
  S steady;            ///< reference of `resistance`; 0: none
  S steady_K;          ///< temperature with the whole cooling, there
  S steady_Pa;         ///< stress, there
  S held_K;            ///< highest steady_K under this load since the last test
  S lease_s;           ///< how long the last test counts where the wire is pressed
  S free_s;            ///< how long the temperature limit has not acted
  S lowest;            ///< resistance since the last test, while not hotter than top_K
  S top_K;
  std::uint8_t doubts;  ///< tests in a row that told too little
  S settled_s;          ///< how long it has been steady where `steady` does not apply
  S slow_K;             ///< temperature with the whole cooling, low-pass filtered
  S since_s;            ///< time since the last test
  S tested_s;           ///< how long the running test has lasted; 0: none
  S blind_s;            ///< how long there has been no valid resistance

  /// Cooling as a share of the file's; 1 where it is not known to be weaker.
  S known() const { return weak ? cooling : S(1); }
  /// Temperature that the power is to be limited by; 0: not known.
  S limit_K() const { return weak && hot ? temperature_K[share] : S(0); }

  /// As if a test had just confirmed the file's cooling: for simulations in which that is known and
  /// tests would only disturb.
  void confirm() {
    confirmed = true;
    since_s = held_K = S(0);
  }
  /// Cost: 120 operations while the wire is hot, three divisions among them; else next to none.
  void advance(const MonitorInputs<S>& seen);

 private:
  static constexpr S becomes_hot = S(0.3);  ///< martensite and R-phase
  static constexpr S is_cold = S(0.6);      ///< where the resistance has told nothing
  static constexpr S rise = S(0.015);       ///< of the resistance, which ends a test
  static constexpr S filter_s = S(0.01);
  /// So far below the beginning of A2R or A2M the resistance has risen by `rise`; within 7 K in
  /// simulated wires.
  static constexpr S below_start_K = S(6);
  /// Where A2M begins by so much above A2R the resistance does not rise enough to be seen.
  static constexpr S a2m_before_a2r_K = S(25);
  static constexpr S enough = S(0.7);  ///< share with which the wire stays below its limit
  static constexpr S enough_in_doubt = S(0.85);
  static constexpr std::uint8_t max_doubts = 3;
  static constexpr S sure = S(0.9);         ///< greater results need no better test
  static constexpr S sure_K = S(50);        ///< between the shares' temperatures: a good test
  static constexpr S error = S(0.2);        ///< of a bad one
  static constexpr S told_apart_K = S(20);  ///< by the coldest and the hottest share
  static constexpr S max_test = S(16);      ///< time constants of the wire in still air
  static constexpr S max_blind_s = S(0.03);
  static constexpr S pressed_K = S(12);       ///< below the limit
  static constexpr S pressed_s = S(0.5);      ///< after the limit has acted
  static constexpr S pressed_cold = S(0.05);  ///< martensite and R-phase
  static constexpr S first_lease_s = S(1), last_lease_s = S(20);
  static constexpr S allowed_K = S(3);    ///< above the limit
  static constexpr S hot_spot = S(0.33);  ///< of limits.hot_spot_K: what a healthy wire has
  static constexpr S close_K = S(20);     ///< to the limit: no time is to be lost
  static constexpr S moved = S(1e-3);     ///< resistance that has moved by itself
  static constexpr S moved_1_K = S(3e-4);
  static constexpr S fallen_K = S(20);  ///< by less power
  static constexpr S again_s = S(5);    ///< between tests of weak cooling

  S hottest_K(const MonitorInputs<S>& seen, const S& wire_K) const {
    return wire_K + hot_spot * seen.prepared.settings.limits.hot_spot_K;
  }
  void forget() { *this = CoolingGuard{}; }
  void integrate(const MonitorInputs<S>& seen);
  void judge(const MonitorInputs<S>& seen, const S& transforms_K);
  void doubt(const MonitorInputs<S>& seen);
  void watch(const MonitorInputs<S>& seen);
  void settle(const MonitorInputs<S>& seen, bool loaded);
  void take(const MonitorInputs<S>& seen);
  bool is_pressed(const MonitorInputs<S>& seen) const;
  bool wants_test(const MonitorInputs<S>& seen) const;
};

template <class S>
void CoolingGuard<S>::advance(const MonitorInputs<S>& seen) {
  const Estimate<S>& e = seen.estimate;
  since_s = since_s < S(1000) ? since_s + seen.dt_s : since_s;
  const bool limited = seen.last.limited_by(LimitReason::temperature);
  free_s = limited ? S(0) : free_s < S(1000) ? free_s + seen.dt_s : free_s;
  if (seen.off() && seen.cold()) {
    forget();  // a fan may have stopped meanwhile
    return;
  }
  const S cold = e.martensite + e.r_phase;
  if (!hot && !(cold < becomes_hot)) {
    return;
  }
  const Pair<S>(&c)[3] = seen.prepared.observer.model.kinetics.a2m_a2r.start_K;
  const Pair<S> sigma(seen.filter.stress_Pa);
  const Pair<S> start_K = c[0] + sigma * (c[1] + sigma * c[2]);
  const S a2m_K = start_K.first();
  const S a2r_K = start_K.second();
  if (!hot) {
    if (a2r_K + a2m_before_a2r_K < a2m_K) {
      return;
    }
    hot = true;
    temperature_K.fill(e.temperature_K);
    peak_K = temperature_K;
    slow_K = e.temperature_K;
    resistance = min = steady = lowest = settled_s = held_K = S(0);
    overheated = false;
    tested_s = blind_s = noise = S(0);
  }
  integrate(seen);
  if (!seen.measurement.resistance_valid) {
    // The rise of the resistance may go by unseen.
    blind_s += seen.dt_s;
    hot = hot && blind_s < max_blind_s;
    probing = probing && hot;
    return;
  }
  blind_s = S(0);
  take(seen);
  const S transforms_K = (a2r_K < a2m_K ? a2m_K : a2r_K) - below_start_K;
  if (min + rise * min + S(2) * noise < resistance) {
    judge(seen, transforms_K);
    return;
  }
  const ThermalBody<S>& body = seen.prepared.observer.model.body;
  tested_s = probing ? tested_s + seen.dt_s : S(0);
  if (max_test * body.capacity_J_K < tested_s * body.loss_W_K) {
    // Without power it stays hot, or its resistance is not what is read.
    weak = true;
    confirmed = hot = probing = false;
    share = 0;
    cooling = shares[0];
    since_s = S(0);
    return;
  }
  if (is_cold < cold) {
    // Cold by the observer without a rise: where A2M comes first the resistance may tell nothing.
    confirmed = confirmed || (probing && a2r_K < a2m_K);
    since_s = S(0);
    hot = probing = false;
    return;
  }
  watch(seen);
  probing = probing || wants_test(seen);
}

/// Filters the resistance, and keeps its lowest value.
template <class S>
void CoolingGuard<S>::take(const MonitorInputs<S>& seen) {
  const S now = HotResistance<S>::share_of_austenite(seen);
  const S within_s = seen.precise() ? filter_s : S(4) * filter_s;
  resistance = S(0) < resistance
                   ? resistance + (now - resistance) * (seen.dt_s / (seen.dt_s + within_s))
                   : now;
  noise += (magnitude(now - resistance) - noise) * (S(5) * seen.dt_s);
  min = S(0) < min && min < resistance ? min : resistance;
}

template <class S>
bool CoolingGuard<S>::is_pressed(const MonitorInputs<S>& seen) const {
  const SoftLimits<S>& q = seen.prepared.settings.limits;
  const Estimate<S>& e = seen.estimate;
  const bool close = q.temperature_K - q.hot_spot_K - pressed_K < temperature_K[whole];
  return close && (free_s < pressed_s || e.martensite + e.r_phase < pressed_cold);
}

template <class S>
bool CoolingGuard<S>::wants_test(const MonitorInputs<S>& seen) const {
  const SoftLimits<S>& q = seen.prepared.settings.limits;
  if (weak) {
    return again_s < since_s;
  }
  if (confirmed) {
    return lease_s < since_s && is_pressed(seen);
  }
  return q.temperature_K + allowed_K < hottest_K(seen, temperature_K[least]);
}

template <class S>
void CoolingGuard<S>::integrate(const MonitorInputs<S>& seen) {
  const ThermalBody<S>& body = seen.prepared.observer.model.body;
  const auto& f = seen.filter;
  const S believed_K = f.ambient_K < f.start_ambient_K ? f.start_ambient_K : f.ambient_K;
  const S air_K = believed_K < seen.in.ambient_K ? seen.in.ambient_K : believed_K;
  const S given_A = seen.last.drive_current_A;
  const S power_W = seen.in.fresh && seen.measurement.power_valid
                        ? seen.measurement.power_W
                        : given_A * given_A * seen.prepared.cold_ohm;
  const S K_J = seen.dt_s / body.capacity_J_K;
  const S max_K = seen.prepared.observer.tuning.hottest_K;
  for (std::size_t i = 0; i < count; ++i) {
    const S T = temperature_K[i];
    const S next_K = T + (power_W - shares[i] * body.loss_W(T - air_K)) * K_J;
    temperature_K[i] = next_K < max_K ? next_K : max_K;
    peak_K[i] = peak_K[i] < temperature_K[i] ? temperature_K[i] : peak_K[i];
  }
}

/// The resistance has risen: the wire has the temperature at which it transforms. Where the wire
/// was hot for too short a time all shares are possible, and nothing is told.
template <class S>
void CoolingGuard<S>::judge(const MonitorInputs<S>& seen, const S& transforms_K) {
  hot = probing = false;
  if (temperature_K[0] - temperature_K[whole] < told_apart_K) {
    return;
  }
  std::uint8_t i = 0;
  while (i + 1U < whole && !(temperature_K[i + 1U] < transforms_K)) {
    ++i;
  }
  const S spread_K = temperature_K[0] - temperature_K[whole];
  const S place = (temperature_K[i] - transforms_K) / (temperature_K[i] - temperature_K[i + 1U]);
  const S part = place < S(0) ? S(0) : place < S(1) ? place : S(1);
  cooling = shares[i] + part * (shares[i + 1U] - shares[i]);
  const S was_K = peak_K[i] + part * (peak_K[i + 1U] - peak_K[i]);
  share = i;
  since_s = S(0);
  const bool good = sure < cooling || sure_K < spread_K;
  doubts = good ? std::uint8_t{0} : static_cast<std::uint8_t>(doubts + 1U);
  const bool decided = good || max_doubts <= doubts;
  const S needed = weak ? sure : decided && !good ? enough_in_doubt : enough;
  weak = cooling < needed;
  confirmed = !weak && decided;
  doubts = decided ? std::uint8_t{0} : doubts;
  lowest = S(0);
  const S longer_s = lease_s + lease_s;
  lease_s = longer_s < first_lease_s  ? first_lease_s
            : longer_s < last_lease_s ? longer_s
                                      : last_lease_s;
  // What is less by the error of a short test remains possible.
  least = 0;
  while (!weak && least < share && shares[least + 1U] < cooling - error) {
    ++least;
  }
  overheated =
      weak && seen.prepared.settings.limits.temperature_K + allowed_K < hottest_K(seen, was_K);
}

/// The cooling has changed: all shares are possible, from what the wire was until now.
template <class S>
void CoolingGuard<S>::doubt(const MonitorInputs<S>& seen) {
  if (!confirmed && !weak) {
    return;
  }
  const S T = temperature_K[weak ? share : whole];
  const SoftLimits<S>& q = seen.prepared.settings.limits;
  probing = weak || q.temperature_K - q.hot_spot_K - close_K < T;
  confirmed = false;
  least = 0;
  temperature_K.fill(T);
  peak_K.fill(T);
  steady = lowest = lease_s = S(0);
}

/// The wire is held at another temperature than before. With less power under the same load it is
/// colder, but has stayed austenite; or it is as hot as it was, and is cooled less.
template <class S>
void CoolingGuard<S>::settle(const MonitorInputs<S>& seen, bool loaded) {
  const SoftLimits<S>& q = seen.prepared.settings.limits;
  const S T = temperature_K[whole];
  const bool fallen = loaded && T < held_K - fallen_K;
  held_K = loaded && T < held_K ? held_K : T;
  steady = resistance;
  steady_K = T;
  steady_Pa = seen.filter.stress_Pa;
  settled_s = S(0);
  if (fallen && confirmed && q.temperature_K + allowed_K < hottest_K(seen, temperature_K[0])) {
    confirmed = false;
    probing = true;
    least = 0;
  }
}

/// While the wire is held, whether its resistance has moved though its power and load have not.
template <class S>
void CoolingGuard<S>::watch(const MonitorInputs<S>& seen) {
  const S sigma = seen.filter.stress_Pa;
  const S T = temperature_K[whole];
  slow_K += (T - slow_K) * (S(10) * seen.dt_s);
  if (!seen.precise()) {
    return;
  }
  const S off_K = magnitude(T - steady_K);
  const S off_Pa = magnitude(sigma - steady_Pa);
  const S moves_K = magnitude(T - slow_K);
  const bool loaded = S(0) < steady && off_Pa < S(0.05) * sigma;
  // No lower than when it was as hot, whatever it has done since.
  if (since_s < S(2) || !(S(0) < lowest) || top_K < T || !loaded) {
    top_K = since_s < S(2) || !(T < top_K) ? T : top_K;
    lowest = S(0) < lowest && lowest < resistance ? lowest : resistance;
  } else if (resistance < lowest - S(2) * moved * lowest) {
    doubt(seen);
    return;
  }
  if (!loaded || !(off_K < S(4))) {
    settled_s = moves_K < S(1.5) ? settled_s + seen.dt_s : S(0);
    steady = loaded ? steady : S(0);
    if (S(0.3) < settled_s) {
      settle(seen, loaded);
    }
    return;
  }
  settled_s = S(0);
  const S settling = moved * S(3) / (since_s + S(0.1));
  const S allowed = moved + settling + moved_1_K * off_K + S(0.02) * off_Pa / sigma;
  if (moves_K < S(2) && allowed * steady < magnitude(resistance - steady)) {
    doubt(seen);
  }
}

}  // namespace smaservo
