// Which wire moves a load: the makers' own figures, an independent wire, and what must hold for any
// task.

#include "host-sim/choose/choose.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>

#include "host-sim/choose/air.hpp"
#include "model/files/error.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"
#include "model/wire/distributed.hpp"

namespace smaservo::choose {
namespace {

using ::testing::HasSubstr;

Task some_task() {
  return {.force_N = 5,
          .stroke_m = 4e-3,
          .time_s = 0.5,
          .length_m = {},
          .spring = {},
          .supply_V = {},
          .ambient_K = room_K};
}

const Suitable* find(const Choice& choice, const std::string& wire) {
  const auto found = std::ranges::find(choice.suitable, wire, &Suitable::wire);
  return found == choice.suitable.end() ? nullptr : &*found;
}

std::string why(const Choice& choice, const std::string& wire) {
  const auto found = std::ranges::find(choice.others, wire, &Unsuitable::wire);
  return found == choice.others.end() ? "" : found->why;
}

Wire<double> cut(const Suitable& s) {
  Wire<double> wire = files::load_wire(s.wire).wire;
  wire.geometry.length_m = s.length_m;
  return wire;
}

/// What pulls on one of the wires, contracted by x_m.
double load_N(const Task& t, const Suitable& s, double x_m, bool contracting) {
  double N = contracting || !t.one_way ? t.force_N : 0;
  if (s.spring) {
    N += s.spring->preload_N + s.spring->rate_N_m * std::max(0.0, x_m);
  }
  return N / s.parallel;
}

/// The contraction that a constant current makes, in steps of 0.1 ms.
double contracted_m(const Task& t, const Suitable& s, double current_A) {
  WirePlant<double> plant(cut(s), load_N(t, s, 0, false), t.ambient_K);
  const double rest = plant.output().strain;
  double x_m = 0;
  constexpr double dt_s = 1e-4;
  const int steps = static_cast<int>(std::lround(t.time_s / dt_s));
  for (int i = 0; i < steps; ++i) {
    plant.update({current_A, load_N(t, s, x_m, true), t.ambient_K, 1}, dt_s);
    x_m = s.length_m * (rest - plant.output().strain);
  }
  return x_m;
}

TEST(ChooseMakers, TheirCurrentsAndTimesFollowFromTheModel) {
  const std::vector<MakersCheck> all = check_makers();
  EXPECT_EQ(all.size(), 24U);
  for (const MakersCheck& c : all) {
    const double diameter_m = files::load_wire(c.wire).wire.geometry.diameter_m;
    if (diameter_m < 0.095e-3) {
      // README.md: the makers' currents cannot heat these wires as far, and they cool sooner.
      EXPECT_LT(c.cooling_s, c.makers_cooling_s) << c.wire;
      continue;
    }
    // To two digits, as the table has them.
    EXPECT_NEAR(c.current_A / c.makers_current_A, 1, 0.2049) << c.wire;
    EXPECT_NEAR(c.cooling_s / c.makers_cooling_s, 1, 0.2049) << c.wire;
  }
}

TEST(ChooseMakers, HaveEachPresetWithForcesInOrder) {
  std::set<std::string> presets;
  for (const MakersWire& m : makers_wires()) {
    presets.insert(m.preset);
    const double area_m2 = m.wire.geometry.area_m2();
    EXPECT_LT(m.stretching_load_N, m.allowed_load_N(Life::many)) << m.preset;
    EXPECT_LE(m.allowed_load_N(Life::many), m.allowed_load_N(Life::few)) << m.preset;
    // The makers round to two digits.
    EXPECT_NEAR(m.stretching_load_N / area_m2, 71e6, 8e6) << m.preset;
    EXPECT_NEAR(m.allowed_load_N(Life::many) / area_m2, 175e6, 30e6) << m.preset;
  }
  const std::vector<std::string> names = files::preset_names();
  EXPECT_EQ(presets, std::set<std::string>(names.begin(), names.end()));
}

TEST(ChooseFan, AgreesWithMeasuredThinWires) {
  // Printed examples of the formula.
  EXPECT_NEAR(cross_flow_nusselt(120, 0.71), 5.65356, 1e-4);
  EXPECT_NEAR(cross_flow_nusselt(6071, 0.7), 40.6371, 1e-3);
  // Collis and Williams (1959): hot wires in air, without the factor of the temperatures.
  for (double reynolds = 0.3; reynolds < 140; reynolds *= 1.3) {
    const double measured =
        reynolds < 44 ? 0.24 + 0.56 * std::pow(reynolds, 0.45) : 0.48 * std::pow(reynolds, 0.51);
    EXPECT_NEAR(cross_flow_nusselt(reynolds, 0.71), measured, 0.1 * measured) << reynolds;
  }
  EXPECT_EQ(fan_draught(76e-6, 0, 360, room_K), 1) << "still air";
}

TEST(Choose, WiresContractInTimeAndNoSooner) {
  std::mt19937_64 random(1);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto logarithmic = [&](double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  };
  int wires = 0;
  int tasks = 0;
  while (wires < 25) {
    Task t = some_task();
    t.force_N = logarithmic(0.02, 60);
    t.stroke_m = logarithmic(3e-4, 0.05);
    t.time_s = logarithmic(0.05, 5);
    t.ambient_K = uniform(253, 318);
    t.one_way = uniform(0, 1) < 0.3;
    t.life = uniform(0, 1) < 0.2 ? Life::few : Life::many;
    t.parallel = uniform(0, 1) < 0.3 ? 3 : 1;
    if (uniform(0, 1) < 0.2) {
      t.supply_V = logarithmic(1, 24);
    }
    const Choice choice = choose_wires(t);
    ++tasks;
    ASSERT_EQ(choice.suitable.size() + choice.others.size(), makers_wires().size());
    EXPECT_TRUE(std::ranges::is_sorted(choice.suitable, {}, &Suitable::power_W));
    for (const Suitable& s : choice.suitable) {
      const std::string what = fmt::format("{} of task {}", s.wire, tasks);
      const auto maker = std::ranges::find(makers_wires(), s.wire, &MakersWire::preset);
      const double area_m2 = maker->wire.geometry.area_m2();
      EXPECT_LE(s.stress_Pa * area_m2, 1.01 * maker->allowed_load_N(t.life)) << what;
      EXPECT_GE(s.cold_stress_Pa * area_m2, 0.94 * maker->stretching_load_N) << what;
      EXPECT_LE(s.strain, 1.001 * maker->allowed_stroke(t.life, s.spring.has_value())) << what;
      EXPECT_LE(s.voltage_V, t.supply_V.value_or(1e9)) << what;
      EXPECT_LE(s.hottest_K, maker->wire.limits.temperature_K + 1) << what;
      EXPECT_LT(s.hold_A, s.current_A * 1.001) << what;
      EXPECT_LT(0, s.power_W) << what;
      if (s.back_still_s) {
        ASSERT_TRUE(s.back_fan_s) << what;
        EXPECT_LE(*s.back_fan_s, *s.back_still_s) << what;
      }
      if (s.overheats_s) {
        EXPECT_GT(*s.overheats_s, t.time_s * 0.9) << what;
      }
    }
    if (!choice.suitable.empty()) {
      // Of each task one wire, in steps that are much finer.
      const auto i =
          static_cast<std::size_t>(uniform(0, static_cast<double>(choice.suitable.size()) - 1e-9));
      const Suitable& s = choice.suitable[i];
      EXPECT_GE(contracted_m(t, s, 1.01 * s.current_A), t.stroke_m) << s.wire << tasks;
      EXPECT_LT(contracted_m(t, s, 0.98 * s.current_A), t.stroke_m) << s.wire << tasks;
      ++wires;
    }
  }
}

/// A wire of many parts, whose clamps are cold and whose convection follows the formula itself.
TEST(Choose, AWireOfManyPartsDoesNearlyTheSame) {
  constexpr std::size_t segments = 24;
  using Model = DistributedPlant<ThreePhase<double>, segments>;
  for (const char* name : {"flexinol-lt-0.20mm", "smartflex-200um", "flexinol-ht-0.25mm"}) {
    const Task t = some_task();
    const Choice choice = choose_wires(t);
    const Suitable* s = find(choice, name);
    ASSERT_NE(s, nullptr) << name;
    const Wire<double> wire = cut(*s);
    Model::Params params{};
    params.kinetics.fill(wire.kinetics);
    params.material = wire.material;
    params.heat = wire.heat;
    params.geometry = wire.geometry;
    params.length_m.fill(wire.geometry.length_m / segments);
    auto state = Model::rest(params, {t.ambient_K, s->cold_stress_Pa});
    const double rest = Model::strain(params, state);
    constexpr double dt_s = 1e-3;
    for (double time_s = 0; time_s < t.time_s; time_s += dt_s) {
      Model::advance(params, state, s->current_A, {s->stress_Pa, t.ambient_K}, 1, dt_s);
    }
    const double x_m = s->length_m * (rest - Model::strain(params, state));
    // In half a second the clamps' cold has not come as far as in the lumped wire, where it is
    // there from the start: so the wire of parts contracts more, by at most what the ends are.
    const double ends = cold_ends(wire.geometry, wire.heat, wire.kinetics).share;
    EXPECT_GT(x_m, 0.98 * t.stroke_m) << name;
    EXPECT_LT(x_m, (1 + ends + 0.02) * t.stroke_m) << name;
    double back_s = 0;
    const auto left_m = [&] { return s->length_m * (rest - Model::strain(params, state)); };
    for (; left_m() > 0.05 * t.stroke_m && back_s < 60; back_s += dt_s) {
      Model::advance(params, state, 0, {s->cold_stress_Pa, t.ambient_K}, 1, dt_s);
    }
    EXPECT_NEAR(back_s, s->back_still_s.value_or(0), 0.1 * back_s) << name;
  }
}

TEST(Choose, SideBySideShareTheForceAndAddTheirVoltages) {
  const Task one = some_task();
  Task two = some_task();
  two.force_N = 2 * one.force_N;
  two.parallel = 2;
  const Choice single = choose_wires(one);
  const Choice both = choose_wires(two);
  const Suitable* a = find(single, "flexinol-lt-0.20mm");
  const Suitable* b = find(both, "flexinol-lt-0.20mm");
  ASSERT_TRUE(a != nullptr && b != nullptr);
  EXPECT_EQ(b->parallel, 2);
  EXPECT_NEAR(b->current_A, a->current_A, 1e-9);
  EXPECT_NEAR(b->voltage_V, 2 * a->voltage_V, 1e-9);
  EXPECT_NEAR(b->power_W, 2 * a->power_W, 1e-9);
  EXPECT_EQ(b->length_m, a->length_m);
}

TEST(Choose, WhatHelpsLowersTheCurrent) {
  const Choice before = choose_wires(some_task());
  Task slower = some_task();
  slower.time_s = 2;
  Task warmer = some_task();
  warmer.ambient_K = 308;
  const std::string wire = "flexinol-ht-0.20mm";
  const double usual_A = find(before, wire)->current_A;
  EXPECT_LT(find(choose_wires(slower), wire)->current_A, 0.8 * usual_A);
  const Choice warm = choose_wires(warmer);
  EXPECT_LT(find(warm, wire)->current_A, usual_A);
  EXPECT_GT(*find(warm, wire)->back_still_s, *find(before, wire)->back_still_s);
}

TEST(Choose, ALoadThatDoesNotPullBackGetsASpringThatDoes) {
  Task t = some_task();
  t.force_N = 3;
  t.one_way = true;
  const Choice choice = choose_wires(t);
  const Suitable* s = find(choice, "flexinol-lt-0.25mm");
  ASSERT_NE(s, nullptr);
  ASSERT_TRUE(s->spring);
  EXPECT_NEAR(s->spring->preload_N, 0.356 * 9.80665, 1e-3) << "the maker's force";
  EXPECT_TRUE(s->back_still_s);
  // The same spring, given by a person, leads to the same wire.
  Task own = t;
  own.spring = s->spring;
  const Choice with_own = choose_wires(own);
  const Suitable* same = find(with_own, s->wire);
  ASSERT_NE(same, nullptr);
  EXPECT_EQ(same->current_A, s->current_A);
  EXPECT_EQ(same->length_m, s->length_m);
  // Half of it does not stretch the wire.
  own.spring->preload_N *= 0.5;
  EXPECT_THAT(why(choose_wires(own), s->wire), HasSubstr("do not stretch the cold wire"));
}

/// A wire can be softer than the spring that pulls it.
TEST(Choose, AStiffSpringDoesNotShakeTheWire) {
  Task t = some_task();
  t.force_N = 0;
  t.stroke_m = 1e-3;
  t.length_m = 0.5;
  for (const double rate_N_m : {2.5e3, 25e3, 1e6}) {
    t.spring = Spring{2.3, rate_N_m};
    t.life = Life::few;
    t.parallel = 1;
    const Choice choice = choose_wires(t);
    EXPECT_EQ(choice.suitable.empty(), rate_N_m > 20e3) << rate_N_m;
    for (const Suitable& s : choice.suitable) {
      EXPECT_TRUE(std::ranges::is_sorted(s.heating.contraction_m)) << s.wire;
      EXPECT_TRUE(std::ranges::is_sorted(s.still.contraction_m, std::greater<>())) << s.wire;
      EXPECT_GE(s.heating.contraction_m.front(), -1e-12) << s.wire;
    }
  }
}

TEST(Choose, NamesTheFewestWiresThatFail) {
  Task t = some_task();
  t.parallel = 8;
  t.supply_V = 12;
  // Four do it with a greater voltage; eight would need twice that.
  const Choice choice = choose_wires(t);
  EXPECT_THAT(why(choice, "4 x smartflex-100um"), HasSubstr("needs 1"));
  t.supply_V = {};
  EXPECT_EQ(find(choose_wires(t), "smartflex-100um")->parallel, 4);
}

TEST(Choose, SaysWhyAWireFallsOut) {
  Task t = some_task();
  EXPECT_THAT(why(choose_wires(t), "flexinol-lt-0.10mm"), HasSubstr("637 MPa"));
  const std::string wire = "flexinol-lt-0.20mm";
  t.length_m = 0.08;
  EXPECT_THAT(why(choose_wires(t), wire), HasSubstr("5.00 % of its length; it may move 3."));
  t.length_m = 0.2;
  ASSERT_NE(find(choose_wires(t), wire), nullptr);
  EXPECT_EQ(find(choose_wires(t), wire)->length_m, 0.2);
  t.length_m = {};
  t.supply_V = 3;
  EXPECT_THAT(why(choose_wires(t), wire), HasSubstr("needs 3.5"));
  t = some_task();
  t.ambient_K = 90 + zero_degC_K;
  const Choice hot = choose_wires(t);
  EXPECT_THAT(why(hot, wire), HasSubstr("in air of 90 °C"));
  // A stroke that takes less than the clamps cool needs a longer wire all the same.
  t = some_task();
  t.stroke_m = 1e-5;
  t.length_m = 2e-3;
  EXPECT_THAT(why(choose_wires(t), wire), HasSubstr("its clamps cool too much of 2 mm"));
}

TEST(Choose, RefusesNumbersOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](auto change) {
    Task t = some_task();
    change(t);
    try {
      choose_wires(t);
    } catch (const files::UserError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_THAT(refused([&](Task& t) { t.force_N = nan; }), HasSubstr("force_N = nan"));
  EXPECT_THAT(refused([](Task& t) { t.force_N = -1; }), HasSubstr("force_N = -1: must be between"));
  EXPECT_THAT(refused([](Task& t) { t.stroke_m = 0; }), HasSubstr("stroke_mm = 0"));
  EXPECT_THAT(refused([](Task& t) { t.time_s = 1e-3; }), HasSubstr("time_s = 0.001"));
  EXPECT_THAT(refused([](Task& t) { t.length_m = 1e6; }), HasSubstr("length"));
  EXPECT_THAT(refused([](Task& t) { t.supply_V = 0; }), HasSubstr("supply"));
  EXPECT_THAT(refused([](Task& t) { t.ambient_K = 25; }), HasSubstr("ambient_degC = -248"));
  EXPECT_THAT(refused([](Task& t) { t.fan_m_s = 1e9; }), HasSubstr("fan"));
  EXPECT_THAT(refused([](Task& t) { t.parallel = 0; }), HasSubstr("parallel = 0"));
  EXPECT_THAT(refused([](Task& t) { t.spring = Spring{-1, 0}; }), HasSubstr("preload"));
}

}  // namespace
}  // namespace smaservo::choose
