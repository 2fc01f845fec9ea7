#pragma once
// Heating levels by which a device excites its own wire for `host-sim identify`: full cycles, then
// shrinking inner loops. Level 0 leaves the wire cold, 1 ends above its transformation.

#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
struct Profile {
  static constexpr int cycles = 2;
  static constexpr int loops = 10;

  /// The level at this time; after the profile it stays 0.
  static S level(const ProfileSettings<S>& q, const S& elapsed_s) {
    const S loops_from_s = S(cycles) * q.cycle_s;
    if (elapsed_s < loops_from_s) {
      const S cycle = elapsed_s / q.cycle_s;
      // Each cycle begins cold, so the run begins at rest.
      return cycle - S(static_cast<int>(cycle)) < S(0.45) ? S(0) : S(1);
    }
    const S loop = (elapsed_s - loops_from_s) / q.loop_s;
    if (!(loop < S(loops))) {
      return S(0);
    }
    const int half = static_cast<int>(S(2) * loop);
    S amplitude = S(0.45);
    for (int i = 0; i < half / 2; ++i) {
      amplitude *= S(0.85);
    }
    return half % 2 == 0 ? S(0.55) - amplitude : S(0.55) + amplitude;
  }
};

}  // namespace smaservo
