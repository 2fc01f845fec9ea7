// The filter of a wire that contracts against a hard stop. How well it knows the pull is judged
// with the whole device, on wires that are not its model: tests/firmware/bench/at_stop_test.cpp.

#include <algorithm>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <type_traits>

#include "observer/multiple_model.hpp"
#include "tests/observer/float_params.hpp"
#include "tests/observer/simulated_wire.hpp"

namespace smaservo::stop_test {
namespace {

template <class S>
using Filters = MultipleModelFilter<S>;

template <class S>
typename Filters<S>::Params params_with(double stop_strain) {
  const Filters<double>::Params p{plant_params(bench_wire()), kalman_tuning(bench_wire().accuracy),
                                  stop_strain};
  if constexpr (std::is_same_v<S, float>) {
    auto to = to_float(p);
    to.stop_strain = static_cast<float>(stop_strain);
    return to;
  } else {
    return p;
  }
}

/// What a bench may give from one step to the next: readings fail, the load jumps, the power too.
template <class S>
class RandomInputs {
 public:
  explicit RandomInputs(std::uint64_t seed) : random_(seed) {}

  Measurement<S> next() {
    if (uniform_(random_) < 0.01) {
      power_W_ = 4 * holding_W(363) * uniform_(random_);
      ohm_ = 20 * (1 + 0.3 * uniform_(random_));
    }
    if (uniform_(random_) < 0.002) {
      stress_Pa_ = 5e6 + 300e6 * uniform_(random_);
    }
    Measurement<S> m{};
    m.resistance_ohm = static_cast<S>(ohm_ * (1 + 1e-3 * uniform_(random_)));
    m.resistance_sd_ohm = static_cast<S>(0.01);
    m.power_W = static_cast<S>(power_W_);
    m.stress_Pa = static_cast<S>(stress_Pa_);
    m.power_valid = true;
    m.resistance_valid = uniform_(random_) < 0.9;
    m.stress_valid = uniform_(random_) < 0.9;
    return m;
  }
  S step_s() { return static_cast<S>(1e-4 + 4.9e-3 * uniform_(random_)); }

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_;
  double power_W_ = 0, ohm_ = 22, stress_Pa_ = 120e6;
};

TEST(KalmanStop, OutOfReachItChangesNoBit) {
  const auto without = params_with<double>(0);
  const auto with = params_with<double>(1e-9);
  RandomInputs<double> inputs(1);
  auto a = Filters<double>::start(without, inputs.next(), room_K);
  auto b = a;
  for (int i = 0; i < 20'000; ++i) {
    const Measurement<double> m = inputs.next();
    const double dt_s = inputs.step_s();
    Filters<double>::advance(without, a, m, dt_s);
    Filters<double>::advance(with, b, m, dt_s);
    const Estimate<double> ea = Filters<double>::estimate(without, a);
    const Estimate<double> eb = Filters<double>::estimate(with, b);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(ea.strain), std::bit_cast<std::uint64_t>(eb.strain))
        << i;
    ASSERT_EQ(std::bit_cast<std::uint64_t>(ea.strain_sd),
              std::bit_cast<std::uint64_t>(eb.strain_sd))
        << i;
  }
}

/// Whatever comes in, the filter stays finite, the stop only pulls, and never lets go too early.
template <class S>
void holds_for_any_input(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const double stop_strain = std::uniform_real_distribution<double>(0.006, 0.06)(random);
  const auto p = params_with<S>(stop_strain);
  RandomInputs<S> inputs(seed);
  auto s = Filters<S>::start(p, inputs.next(), static_cast<S>(room_K));
  int held = 0;
  double squares = 0;
  for (int i = 0; i < 5000; ++i) {
    const Measurement<S> m = inputs.next();
    Filters<S>::advance(p, s, m, inputs.step_s());
    const Estimate<S> e = Filters<S>::estimate(p, s);
    ASSERT_TRUE(std::isfinite(e.strain) && std::isfinite(e.strain_sd)) << seed << ", " << i;
    const auto& f = Filters<S>::likeliest(s);
    ASSERT_TRUE(std::isfinite(f.stress_Pa)) << seed << ", " << i;
    ASSERT_GE(f.stress_Pa, f.load_Pa) << seed << ", " << i;
    // No greater stress is searched for: no wire bears it. There the strain is what it is.
    const S most_Pa = S(1.5e9);
    ASSERT_LE(f.stress_Pa, most_Pa) << seed << ", " << i;
    if (KalmanObserver<S>::held(f) && f.stress_Pa < S(0.99) * most_Pa) {
      ++held;
      const auto strain = static_cast<double>(KalmanObserver<S>::whole_strain(p, f));
      squares += (strain - stop_strain) * (strain - stop_strain);
    }
  }
  EXPECT_GT(held, 0) << seed << ", " << stop_strain;
  // With such steps the strain jumps over that of the stop where a turning point is passed.
  EXPECT_LT(std::sqrt(squares / std::max(held, 1)), 1e-3) << seed << ", " << stop_strain;
}

TEST(KalmanStop, HoldsForAnyInput) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    holds_for_any_input<double>(seed);
    holds_for_any_input<float>(seed);
  }
}

/// A filter that has contradicted the resistance just before the wire touches its stop: there no
/// reading decides between hypotheses, so a search would never end. It begins when the wire is
/// free.
TEST(KalmanStop, ADoubtWaitsUntilTheWireIsFree) {
  auto p = params_with<double>(0);
  Measurement<double> m{};
  m.stress_Pa = 120e6;
  m.resistance_sd_ohm = 0.01;
  m.power_valid = m.stress_valid = m.resistance_valid = true;
  auto s = Filters<double>::start(p, m, room_K);
  // The wire's own resistance, and with `wrong_by` one that no state of it explains.
  const auto run = [&](double power_W, int steps, double wrong_by, auto&& after) {
    for (int i = 0; i < steps; ++i) {
      m.power_W = power_W;
      m.resistance_ohm = (1 + wrong_by) * Filters<double>::likeliest(s).model_ohm;
      Filters<double>::advance(p, s, m, 1e-3);
      after();
    }
  };
  const auto one_is_left = [&] {
    return Filters<double>::alive(s) == 1 &&
           Filters<double>::estimate(p, s).health != Health::searching;
  };
  run(2 * holding_W(363), 3000, 0, [] {});
  run(0, 4000, 0, [] {});
  ASSERT_TRUE(one_is_left());
  p.stop_strain = Filters<double>::estimate(p, s).strain;
  int held = 0;
  // The doubt is set, since 1 % for 2 s before the stop would lead the filter elsewhere at once.
  s.filter[s.leader].mismatch = 0.02;
  run(2 * holding_W(363), 3000, 0.1, [&] {
    if (KalmanObserver<double>::held(Filters<double>::likeliest(s))) {
      ++held;
      ASSERT_TRUE(one_is_left()) << held;
    }
  });
  EXPECT_GT(held, 2500);
  int searched = 0;
  run(0, 6000, 0.1, [&] { searched += one_is_left() ? 0 : 1; });
  EXPECT_GT(searched, 0);
}

/// A clamped wire of the filter's own model: the pull follows from the heat alone, and the
/// resistance is not needed.
TEST(KalmanStop, AClampedWirePullsAsItsModel) {
  for (const double load_Pa : {50e6, 120e6, 200e6}) {
    using Model = Plant<ThreePhase<double>>;
    auto p = params_with<double>(0);
    p.model.kinetics.smallest_reversal_K = 0;
    Model::State wire = Model::rest(p.model, {room_K, load_Pa});
    p.stop_strain = Model::strain(p.model, wire);
    Measurement<double> m{};
    m.stress_Pa = load_Pa;
    m.power_valid = m.stress_valid = true;
    auto s = Filters<double>::start(p, m, room_K);
    double greatest_Pa = 0;
    for (int i = 0; i < 6000; ++i) {
      m.power_W = i < 4000 ? 2 * holding_W(363) : 0;
      // The wire's stress, by halving: its strain rises with it.
      double low = load_Pa;
      double high = 1.5e9;
      const auto at = [&](double stress_Pa) {
        Model::State tried = wire;
        Model::advance(p.model, tried, {m.power_W, stress_Pa, room_K}, 1e-3);
        return tried;
      };
      for (int k = 0; k < 45; ++k) {
        const double middle = 0.5 * (low + high);
        (Model::strain(p.model, at(middle)) < p.stop_strain ? low : high) = middle;
      }
      wire = at(low);
      Filters<double>::advance(p, s, m, 1e-3);
      const double pull_Pa = Filters<double>::likeliest(s).stress_Pa;
      ASSERT_NEAR(pull_Pa, low, 5e6 + 0.02 * low) << i;
      greatest_Pa = std::max(greatest_Pa, low);
    }
    EXPECT_GT(greatest_Pa, load_Pa + 150e6);
  }
}

}  // namespace
}  // namespace smaservo::stop_test
