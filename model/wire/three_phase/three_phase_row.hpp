#pragma once
// Three-phase models side by side, each to the bit as if it were stepped alone. One curve alone has
// to wait for its divisions and square roots; here the processor computes eight at once.

#include "model/wire/three_phase/row.hpp"
#include "model/wire/three_phase/three_phase.hpp"

namespace smaservo {

template <class S, std::size_t memory_depth, std::size_t count>
struct Row<ThreePhase<S, memory_depth>, count> {
  static_assert(count % 4 == 0);
  using K = ThreePhase<S, memory_depth>;
  template <class T>
  using Each = std::array<T, count>;

  /// The heading and stress of the last cut. If they have not changed, the cut is used again.
  struct Cut {
    bool known;
    Heading heading;
    S stress_Pa;
  };
  struct Kept {
    Each<Cut> cuts;
    Each<Isobar<Pair<S>>> curves;
  };

  static Each<PhaseRates<S>> rates(const Each<typename K::Params>& p,
                                   const Each<typename K::State>& s, Kept& kept,
                                   const Each<Heading>& heading) {
    Each<Pair<S>> slopes_1_K;
    for (std::size_t i = 0; i < count; ++i) {
      if (K::acts(s[i], heading[i])) {
        cut(p[i], s[i].heading, s[i].reached.stress_Pa, kept, i);
      }
      slopes_1_K[i] = K::left(s[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      slopes_1_K[i] = kept.curves[i].remaining_1_K(slopes_1_K[i]);
    }
    Each<PhaseRates<S>> rates;
    for (std::size_t i = 0; i < count; ++i) {
      rates[i] = K::acts(s[i], heading[i]) ? K::rates(p[i], s[i], slopes_1_K[i])
                                           : PhaseRates<S>{S(0), S(0)};
    }
    return rates;
  }

  static void advance(const Each<typename K::Params>& p, Each<typename K::State>& s, Kept& kept,
                      const Each<S>& temperature_K, const S& stress_Pa) {
    for (std::size_t i = 0; i < count; ++i) {
      cut(p[i], s[i].heading, stress_Pa, kept, i);
    }
    const Each<Pair<S>> left = remaining(kept.curves, temperature_K);
    for (std::size_t i = 0; i < count; ++i) {
      K::advance(p[i], s[i], {temperature_K[i], stress_Pa}, left[i]);
    }
  }

 private:
  static void cut(const typename K::Params& p, Heading heading, const S& stress_Pa, Kept& kept,
                  std::size_t i) {
    Cut& last = kept.cuts[i];
    const bool same = last.known && last.heading == heading && last.stress_Pa <= stress_Pa &&
                      stress_Pa <= last.stress_Pa;
    if (!same) {
      last = {true, heading, stress_Pa};
      kept.curves[i] = K::curves(p, stress_Pa, heading);
    }
  }

  static Each<Pair<S>> remaining(const Each<Isobar<Pair<S>>>& at, const Each<S>& temperature_K) {
    using Two = Pair<Pair<S>>;
    Each<Pair<S>> left;
    for (std::size_t i = 0; i < count; i += 4) {
      const auto two = [&](std::size_t k) {
        return Two(Pair<S>(temperature_K[k]), Pair<S>(temperature_K[k + 1]));
      };
      const Pair<Two> four =
          pair_isobars(pair_isobars(at[i], at[i + 1]), pair_isobars(at[i + 2], at[i + 3]))
              .remaining(Pair<Two>(two(i), two(i + 2)));
      left[i] = four.first().first();
      left[i + 1] = four.first().second();
      left[i + 2] = four.second().first();
      left[i + 3] = four.second().second();
    }
    return left;
  }
};

}  // namespace smaservo
