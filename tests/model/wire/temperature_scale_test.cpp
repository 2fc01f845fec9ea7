// What a wire's readings say of its temperature, and what they do not.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "model/wire/plant.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::temperature_scale_test {
namespace {

using Model = Plant<ThreePhase<double>>;

/// Full strokes, shrinking loops, a ripple, a rest.
double power_W(double time_s) {
  const double t = std::fmod(time_s, 10.0);
  return t < 1 ? 0.45 : t < 3 ? 0.05 : t < 8 ? 0.28 + 0.2 * (1 - t / 8) * std::sin(7 * t) : 0;
}

/// But for numerical errors: a step is divided into parts of at most 1 K, with either wire.
TEST(TemperatureScale, NeitherStrainNorResistanceTellsIt) {
  for (const double factor : {0.8, 1.25}) {
    const Wire<double>& wire = paper_wire();
    const Model::Params p = plant_params(wire);
    const Model::Params q = plant_params(warmed(wire, factor));
    for (const double stress_Pa : {10e6, 150e6, 300e6}) {
      Model::State s = Model::rest(p, {room_K, stress_Pa});
      Model::State t = Model::rest(q, {room_K, stress_Pa});
      double hottest_K = room_K;
      for (int i = 0; i < 200'000; ++i) {
        const PlantInput<double> in{power_W(i * 1e-4), stress_Pa, room_K};
        Model::advance(p, s, in, 1e-4);
        Model::advance(q, t, in, 1e-4);
        ASSERT_NEAR(Model::strain(p, s), Model::strain(q, t), 1e-6) << i;
        const double ohm = Model::resistance_ohm(p, s, room_K);
        ASSERT_NEAR(ohm, Model::resistance_ohm(q, t, room_K), 1e-5 * ohm) << i;
        ASSERT_NEAR(factor * (Model::temperature_K(s) - room_K), Model::temperature_K(t) - room_K,
                    0.01);
        hottest_K = std::max(hottest_K, Model::temperature_K(s));
      }
      EXPECT_GT(hottest_K, room_K + 60);
    }
  }
}

}  // namespace
}  // namespace smaservo::test::temperature_scale_test
