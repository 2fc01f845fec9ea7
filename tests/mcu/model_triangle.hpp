#pragma once
// Steps of the model whose instructions and operations are counted.

#include "firmware/prepared.hpp"

namespace smaservo::mcu {

/// Out of line, as a board's loop would call it.
template <class S>
[[gnu::noinline]] void model_step(const typename ThreePhase<S>::Params& p,
                                  const typename ThreePhase<S>::Cut& cut,
                                  typename ThreePhase<S>::State& s, const S& temperature_K) {
  ThreePhase<S>::advance(p, cut, s, temperature_K);
}

/// 20 to 110 °C and back under 150 MPa, twice, as tests/bench/steps.hpp has it: of the second time,
/// count(step).
template <class S, class Count>
void model_triangle(const Prepared<S>& prepared, Count count) {
  constexpr int half = 1800;
  const typename ThreePhase<S>::Params& p = prepared.observer.model.kinetics;
  const auto cut = ThreePhase<S>::cut(p, S(150e6));
  auto state = ThreePhase<S>::rest(p, {S(293.15), S(150e6)});
  for (int i = 1; i <= 4 * half; ++i) {
    const int at = i % (2 * half);
    const S temperature_K =
        S(293.15) + S(0.05) * S(static_cast<float>(at <= half ? at : 2 * half - at));
    const auto step = [&] { model_step<S>(p, cut, state, temperature_K); };
    if (i <= 2 * half) {
      step();
    } else {
      count(step);
    }
  }
}

}  // namespace smaservo::mcu
