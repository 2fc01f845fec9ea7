#include "model/wire/wire_plant.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/bench/convert.hpp"
#include "tests/model/wire/test_wires.hpp"

namespace smaservo::test::wire_plant_test {
namespace {

using Model = Plant<ThreePhase<double>>;
constexpr double load_N = 0.68;

std::array<std::uint64_t, 5> bits(const WireOutput<double>& out) {
  return std::bit_cast<std::array<std::uint64_t, 5>>(out);
}

/// Heats and cools at random; each value holds for a while.
class Drive {
 public:
  explicit Drive(std::uint64_t seed) : random_(seed) {}
  WireInput<double> next() {
    if (left_-- <= 0) {
      left_ = 20 + static_cast<int>(300 * uniform());
      in_ = {.current_A = 0.25 * uniform(),
             .load_N = 0.2 + uniform(),
             .ambient_K = 283 + 30 * uniform(),
             .draught = 0.5 + 2 * uniform()};
    }
    return in_;
  }
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }

 private:
  std::mt19937_64 random_;
  WireInput<double> in_;
  int left_ = 0;
};

TEST(WirePlant, IsTheModelToTheBit) {
  const Wire<double>& wire = paper_wire();
  Model::Params p = plant_params(wire);
  p.kinetics.smallest_reversal_K = 0;
  const ThermalBody<double> still = p.body;
  WirePlant<double> plant(wire, load_N);
  Model::State state = Model::rest(p, {room_K, load_N / wire.geometry.area_m2()});
  Drive drive(1);
  double least = 1;
  double most = 0;
  for (int i = 0; i < 60000; ++i) {
    const WireInput<double> in = drive.next();
    p.body.loss_W_K = in.draught * still.loss_W_K;
    p.body.loss_W_K2 = in.draught * still.loss_W_K2;
    const double ohm = Model::resistance_ohm(p, state, in.ambient_K);
    Model::advance(
        p, state,
        {in.current_A * in.current_A * ohm, in.load_N / wire.geometry.area_m2(), in.ambient_K},
        1e-3);
    const WireOutput<double> out = plant.update(in, 1e-3);
    ASSERT_EQ(out.strain, Model::strain(p, state));
    ASSERT_EQ(out.resistance_ohm, Model::resistance_ohm(p, state, in.ambient_K));
    ASSERT_EQ(out.temperature_K, Model::temperature_K(state));
    least = std::min(least, out.strain);
    most = std::max(most, out.strain);
  }
  // It has made the whole stroke.
  EXPECT_LT(least, 0.008);
  EXPECT_GT(most, 0.039);
}

TEST(WirePlant, DividesALongStep) {
  WirePlant<double> once(paper_wire(), load_N);
  WirePlant<double> parts(paper_wire(), load_N);
  Drive drive(2);
  for (int i = 0; i < 500; ++i) {
    const WireInput<double> in = drive.next();
    const WireOutput<double> out = once.update(in, 0.02);
    for (int k = 0; k < 4; ++k) {
      parts.update(in, 0.005);
    }
    ASSERT_EQ(bits(out), bits(parts.output()));
  }
  // A minute at once is the balance of heat and loss.
  const WireInput<double> hot{.current_A = 0.12, .load_N = load_N};
  const double balanced_K = once.update(hot, 60).temperature_K;
  EXPECT_NEAR(once.update(hot, 60).temperature_K, balanced_K, 1e-6);
}

TEST(WirePlant, LooksAheadWithoutMoving) {
  WirePlant<double> plant(paper_wire(), load_N);
  Drive drive(3);
  for (int i = 0; i < 3000; ++i) {
    const WireInput<double> in = drive.next();
    const auto before = bits(plant.output());
    const auto ahead = bits(plant.after(in, 1e-3));
    ASSERT_EQ(bits(plant.output()), before);
    ASSERT_EQ(bits(plant.update(in, 1e-3)), ahead);
  }
}

/// Each of these changes nothing, whatever it comes between.
TEST(WirePlant, RefusesWhatIsNoInput) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinite = std::numeric_limits<double>::infinity();
  struct Bad {
    WireInput<double> in;
    double dt_s;
  };
  const WireInput<double> good{.current_A = 0.15, .load_N = load_N};
  const auto bad = std::to_array<Bad>({
      {good, 0},
      {good, -1e-3},
      {good, nan},
      {good, infinite},
      {good, 60.1},
      {{.current_A = nan, .load_N = load_N}, 1e-3},
      {{.current_A = infinite, .load_N = load_N}, 1e-3},
      {{.current_A = 0.1, .load_N = nan}, 1e-3},
      {{.current_A = 0.1, .load_N = -infinite}, 1e-3},
      {{.current_A = 0.1, .load_N = load_N, .ambient_K = nan}, 1e-3},
      {{.current_A = 0.1, .load_N = load_N, .ambient_K = -20}, 1e-3},
      {{.current_A = 0.1, .load_N = load_N, .draught = 0}, 1e-3},
      {{.current_A = 0.1, .load_N = load_N, .draught = nan}, 1e-3},
      {{.current_A = 1e200, .load_N = load_N}, 1e-3},
  });
  WirePlant<double> plant(paper_wire(), load_N);
  WirePlant<double> undisturbed = plant;
  Drive drive(4);
  for (int i = 0; i < 5000; ++i) {
    const Bad& now = bad.at(static_cast<std::size_t>(drive.uniform() * bad.size()));
    const WireOutput<double> none = plant.update(now.in, now.dt_s);
    ASSERT_TRUE(std::isnan(none.strain) && std::isnan(none.resistance_ohm) &&
                std::isnan(none.temperature_K) && std::isnan(none.martensite) &&
                std::isnan(none.r_phase));
    const WireInput<double> in = drive.next();
    ASSERT_EQ(bits(plant.update(in, 1e-3)), bits(undisturbed.update(in, 1e-3)));
  }
}

TEST(WirePlant, RestForgetsEverything) {
  WirePlant<double> plant(paper_wire(), load_N);
  const auto rested = bits(plant.output());
  Drive drive(5);
  for (int i = 0; i < 2000; ++i) {
    plant.update(drive.next(), 1e-3);
  }
  ASSERT_NE(bits(plant.output()), rested);
  plant.rest(load_N, room_K);
  EXPECT_EQ(bits(plant.output()), rested);
}

TEST(WirePlant, IsNearlyTheSameInSinglePrecision) {
  WirePlant<double> exact(paper_wire(), load_N);
  WirePlant<float> single(benchmarks::convert<float>(paper_wire()), static_cast<float>(load_N));
  double worst = 0;
  for (int i = 0; i < 8000; ++i) {
    const double A = i % 4000 < 1500 ? 0.17 : 0.02;
    const double strain = exact.update({.current_A = A, .load_N = load_N}, 1e-3).strain;
    const float other =
        single
            .update({.current_A = static_cast<float>(A), .load_N = static_cast<float>(load_N)},
                    1e-3F)
            .strain;
    worst = std::max(worst, std::abs(strain - static_cast<double>(other)));
  }
  EXPECT_LT(worst, 4e-5);  // 0.1 % of a 4 % stroke
  EXPECT_GT(worst, 0);
}

}  // namespace
}  // namespace smaservo::test::wire_plant_test
