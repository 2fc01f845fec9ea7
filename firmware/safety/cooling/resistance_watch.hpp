#pragma once
// Detects that the resistance of a hot wire has moved although power and load have not: then the
// wire's cooling has changed. The resistance is taken as a share of austenite's under the load.

#include "firmware/safety/monitor/hot_resistance.hpp"

namespace smaservo {

/// All zero: nothing has been read.
template <class S>
struct ResistanceWatch {
  /// The result of one sample.
  enum class Finding : std::uint8_t {
    none,
    moved,   ///< the resistance has moved by itself
    settled  ///< the wire is held at a new temperature, as computed with the file's cooling
  };

  S share;     ///< of austenite's resistance, filtered; 0: none yet
  S noise;     ///< mean distance of the readings from `share`
  S min;       ///< lowest share since the wire became hot
  S steady;    ///< share while the wire was last held; 0: none
  S steady_K;  ///< temperature at `steady`, as computed with the file's cooling
  S steady_Pa;
  S held_K;     ///< highest steady_K under this load since the last test
  S settled_s;  ///< time for which the wire has been held in a state to which `steady` does not
                ///< apply
  S slow_K;     ///< temperature as computed with the file's cooling, low-pass filtered
  S lowest;     ///< lowest share since the last test, while not hotter than top_K; 0: none yet
  S top_K;
  S coolest;  ///< lowest share since the wire became hot, less what its heat adds; 0: none yet

  /// Begins anew with a wire that has become hot and has this temperature. top_K is kept.
  void start(const S& wire_K) {
    share = noise = min = steady = held_K = settled_s = lowest = coolest = S(0);
    slow_K = wire_K;
  }
  /// Drops the references, the held state and the lowest share: nothing is compared with them.
  void forget() { steady = lowest = S(0); }

  /// Filters the share, and keeps its lowest value. Cost: a division, besides the share's two.
  void take(const MonitorInputs<S>& seen);
  /// Whether the resistance is so far above its lowest value that martensite or R-phase has formed.
  bool risen() const { return min + rise * min + noises * noise < share; }
  /// By how much the wire is hotter than computed, if it is austenite as it was when its resistance
  /// was lowest; 0 if that is within the noise and `hotter`. `wire_K`:
  /// temperature as computed with the file's cooling. Cost: two divisions.
  S hotter_K(const MonitorInputs<S>& seen, const S& wire_K);
  /// `wire_K`: temperature as computed with the file's cooling; `since_s`: time since the last
  /// test.
  Finding look(const MonitorInputs<S>& seen, const S& wire_K, const S& since_s);
  /// Takes the present state as the reference. Returns whether it is far colder than the state held
  /// before under the same load, which means that the power has fallen.
  bool settle(const MonitorInputs<S>& seen, const S& wire_K);

 private:
  /// Rise that shows a transformation: austenite alone would have to become 75 K warmer for it, by
  /// the 2e-4 per kelvin of the wires' files.
  static constexpr S rise = S(0.015);
  /// Time constant: ten samples of 1 ms, or 40 at the minimum current, where readings are noisier.
  static constexpr S filter_s = S(0.01), imprecise = S(4);
  static constexpr S noise_1_s = S(5), noises = S(2);
  /// A wire is held where it stays within 1.5 K of its mean over 0.1 s, for 0.3 s. Loads within 5 %
  /// and temperatures within 4 K are compared, and 2 K from the mean are allowed there.
  static constexpr S slow_1_s = S(10), held_within_K = S(1.5), settles_s = S(0.3);
  static constexpr S same_load = S(0.05), same_K = S(4), moves_K = S(2);
  /// Least change of the share that counts as a motion: that of 5 K of austenite. It is increased
  /// for each kelvin from the reference by martensite's slope, the greatest of the phases, and for
  /// each percent of load by 0.02 %. 1 s after a test it is fourfold, because the last martensite
  /// disappears slowly.
  static constexpr S moved = S(1e-3), moved_1_K = S(3e-4), moved_by_load = S(0.02);
  static constexpr S goes_s = S(3), goes_from_s = S(0.1);
  /// For this time after a test the lowest share is recorded, but not yet compared.
  static constexpr S lowest_after_s = S(2);
  /// Least rise that counts as heat: that of 10 K of austenite.
  static constexpr S hotter = S(2e-3);
  /// Temperature for which `coolest` is kept; any one does.
  static constexpr S reference_K = S(350);
  /// Fall that counts as far: if a strain held at 110 °C loses half its cooling, the wire seems
  /// 42 K colder.
  static constexpr S fallen_K = S(20);

  bool loaded_as_before(const MonitorInputs<S>& seen) const {
    const S sigma = seen.filter.stress_Pa;
    return S(0) < steady && magnitude(sigma - steady_Pa) < same_load * sigma;
  }
};

template <class S>
void ResistanceWatch<S>::take(const MonitorInputs<S>& seen) {
  const S now = HotResistance<S>::share_of_austenite(seen);
  const S within_s = seen.precise() ? filter_s : imprecise * filter_s;
  share = S(0) < share ? share + (now - share) * (seen.dt_s / (seen.dt_s + within_s)) : now;
  noise += (magnitude(now - share) - noise) * (noise_1_s * seen.dt_s);
  min = S(0) < min && min < share ? min : share;
}

template <class S>
S ResistanceWatch<S>::hotter_K(const MonitorInputs<S>& seen, const S& wire_K) {
  if (!seen.precise()) {
    return S(0);
  }
  const Phase<S>& a = seen.prepared.settings.wire.material.austenite;
  const S by_K = a.resistivity_ohm_m_K / a.resistivity_ohm_m;
  if (!(S(0) < by_K)) {
    return S(0);
  }
  const S now = share - share * by_K * (wire_K - reference_K);
  coolest = S(0) < coolest && coolest < now ? coolest : now;
  const S above = now - coolest;
  return above < hotter * coolest + noises * noise ? S(0) : above / (coolest * by_K);
}

template <class S>
auto ResistanceWatch<S>::look(const MonitorInputs<S>& seen, const S& wire_K, const S& since_s)
    -> Finding {
  slow_K += (wire_K - slow_K) * (slow_1_s * seen.dt_s);
  if (!seen.precise()) {
    return Finding::none;
  }
  const S sigma = seen.filter.stress_Pa;
  const S off_K = magnitude(wire_K - steady_K);
  const S off_slow_K = magnitude(wire_K - slow_K);
  const bool loaded = loaded_as_before(seen);
  // The share must not be lower than it was when the wire was as hot.
  const bool early = since_s < lowest_after_s;
  if (early || !(S(0) < lowest) || top_K < wire_K || !loaded) {
    top_K = early || !(wire_K < top_K) ? wire_K : top_K;
    lowest = S(0) < lowest && lowest < share ? lowest : share;
  } else if (share < lowest - (moved + moved) * lowest) {
    return Finding::moved;
  }
  if (!loaded || !(off_K < same_K)) {
    settled_s = off_slow_K < held_within_K ? settled_s + seen.dt_s : S(0);
    steady = loaded ? steady : S(0);
    return settles_s < settled_s ? Finding::settled : Finding::none;
  }
  settled_s = S(0);
  const S going = moved * goes_s / (since_s + goes_from_s);
  const S by_load = moved_by_load * magnitude(sigma - steady_Pa) / sigma;
  const S allowed = moved + going + moved_1_K * off_K + by_load;
  return off_slow_K < moves_K && allowed * steady < magnitude(share - steady) ? Finding::moved
                                                                              : Finding::none;
}

template <class S>
bool ResistanceWatch<S>::settle(const MonitorInputs<S>& seen, const S& wire_K) {
  const bool loaded = loaded_as_before(seen);
  const bool fallen = loaded && wire_K < held_K - fallen_K;
  held_K = loaded && wire_K < held_K ? held_K : wire_K;
  steady = share;
  steady_K = wire_K;
  steady_Pa = seen.filter.stress_Pa;
  settled_s = S(0);
  return fallen;
}

}  // namespace smaservo
