#pragma once
// Temperatures that the wire would have by its heating power, one for each of six assumed shares of
// the cooling that its file states.

#include <array>
#include <cstdint>

#include "firmware/safety/monitor/inputs.hpp"

namespace smaservo {

/// All zero: not started.
template <class S>
struct CoolingShares {
  static constexpr std::size_t count = 6;
  /// The time that the wire takes to cool differs by a quarter to a third between neighbours.
  static constexpr std::array<S, count> shares{S(0.3), S(0.4), S(0.5), S(0.65), S(0.8), S(1)};
  static constexpr std::uint8_t whole = count - 1;

  std::array<S, count> temperature_K;  ///< temperature of the wire with each share
  std::array<S, count> peak_K;         ///< highest temperature since start()

  /// Begins with this temperature of the wire for all shares.
  void start(const S& wire_K) {
    temperature_K.fill(wire_K);
    peak_K.fill(wire_K);
  }
  /// If this is small, the wire was hot for too short a time to distinguish the shares.
  S spread_K() const { return temperature_K[0] - temperature_K[whole]; }

  /// Makes a step with the measured temperature of the air. The observer's is taken only where
  /// there is no sensor: it explains a part of the cooling that is missing by warmer air, 7 K
  /// where 0.7 is left, and a test then finds 0.83. Cost: six times eight operations, a division.
  void integrate(const MonitorInputs<S>& seen);

  /// The cooling with which the wire would have a given temperature now.
  struct Match {
    std::uint8_t share;  ///< index of the next smaller share
    S cooling;           ///< 0.3 to 1
    S peak_K;            ///< highest temperature with this cooling
  };
  /// Cost: a division. spread_K() must be above 0.
  Match match(const S& wire_K) const;
};

template <class S>
void CoolingShares<S>::integrate(const MonitorInputs<S>& seen) {
  const ThermalBody<S>& body = seen.prepared.observer.model.body;
  const auto& f = seen.filter;
  const S believed_K = f.ambient_K < f.start_ambient_K ? f.start_ambient_K : f.ambient_K;
  const S air_K = isfinite(seen.in.ambient_K) ? seen.in.ambient_K : believed_K;
  const S given_A = seen.last.drive_current_A;
  const S power_W = seen.in.fresh && seen.measurement.power_valid
                        ? seen.measurement.power_W
                        : given_A * given_A * seen.prepared.cold_ohm;
  const S K_J = seen.dt_s / body.capacity_J_K;
  const S max_K = seen.prepared.observer.tuning.hottest_K;
  for (std::size_t i = 0; i < count; ++i) {
    const S T = temperature_K[i];
    temperature_K[i] = min(T + (power_W - shares[i] * body.loss_W(T - air_K)) * K_J, max_K);
    peak_K[i] = peak_K[i] < temperature_K[i] ? temperature_K[i] : peak_K[i];
  }
}

template <class S>
auto CoolingShares<S>::match(const S& wire_K) const -> Match {
  std::uint8_t i = 0;
  while (i + 1U < whole && !(temperature_K[i + 1U] < wire_K)) {
    ++i;
  }
  const S place = (temperature_K[i] - wire_K) / (temperature_K[i] - temperature_K[i + 1U]);
  const S part = clamp(place, S(0), S(1));
  return {i, shares[i] + part * (shares[i + 1U] - shares[i]),
          peak_K[i] + part * (peak_K[i + 1U] - peak_K[i])};
}

}  // namespace smaservo
