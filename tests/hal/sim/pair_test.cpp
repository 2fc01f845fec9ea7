// Two wires against each other.

#include "hal/sim/pair.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "hal/sim/lumped_wire.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::test::pair_test {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// Two pieces of the preset, the second one longer, each pulled by the other with 150 MPa.
class Antagonists {
 public:
  explicit Antagonists(bool distributed)
      : first_wire_(files::load_wire(std::string(files::default_wire)).wire),
        second_wire_(first_wire_),
        first_(make(first_wire_, distributed), setup(first_wire_, 1)),
        second_(make(lengthened(second_wire_), distributed), setup(second_wire_, 2)),
        pair_(first_, first_wire_.geometry, second_, second_wire_.geometry) {}

  void run(double first_A, double second_A, int periods) {
    hal::Frame a{};
    hal::Frame b{};
    for (int i = 0; i < periods; ++i) {
      first_.drive({first_A, 0, first_.now_ns() + 2 * ms});
      second_.drive({second_A, 0, second_.now_ns() + 2 * ms});
      pair_.read(a, b);
    }
  }
  double length_m() const {
    return first_.truth().strain * first_wire_.geometry.length_m +
           second_.truth().strain * second_wire_.geometry.length_m;
  }
  double first_N() const { return first_.truth().stress_Pa * first_wire_.geometry.area_m2(); }
  double second_N() const { return second_.truth().stress_Pa * second_wire_.geometry.area_m2(); }
  hal::SimBoard& first() { return first_; }
  hal::SimBoard& second() { return second_; }

 private:
  static Wire<double>& lengthened(Wire<double>& wire) {
    wire.geometry.length_m *= 1.5;
    return wire;
  }
  static std::unique_ptr<hal::SimulatedWire> make(const Wire<double>& wire, bool distributed) {
    std::mt19937_64 random(3);
    return distributed ? hal::make_simulated_wire(hal::Family::sublayers, wire, {}, 0.5, random)
                       : hal::make_lumped_wire(wire);
  }
  static hal::SimSetup setup(const Wire<double>& wire, std::uint64_t seed) {
    return {.period_ns = ms,
            .converter = {.voltage_drive = false,
                          .max_A = 0.5,
                          .slew_A_s = std::numeric_limits<double>::infinity(),
                          .lead_ohm = 0},
            .sensors = {24, 1, 50, 10, 0, 0, 0, 1, 1},
            .load = hal::ConstantLoad{150e6},
            .geometry = wire.geometry,
            .surroundings = {},
            .reads_supply = true,
            .reads_ambient = true,
            .reads_driver = true,
            .seed = seed};
  }

  Wire<double> first_wire_, second_wire_;
  hal::SimBoard first_, second_;
  hal::SimPair pair_;
};

class SimPairs : public ::testing::TestWithParam<bool> {};

TEST_P(SimPairs, WhatOneLosesTheOtherGains) {
  Antagonists pair(GetParam());
  const double space_m = pair.length_m();
  const double rest = pair.first().truth().strain;
  const auto check = [&] {
    ASSERT_NEAR(pair.length_m(), space_m, 2e-9);
    ASSERT_NEAR(pair.first_N(), pair.second_N(), 1e-12);
  };
  double shortest = rest;
  for (int i = 0; i < 1500; ++i) {
    pair.run(0.16, 0, 1);
    check();
    shortest = std::min(shortest, pair.first().truth().strain);
  }
  EXPECT_LT(shortest, rest - 0.004) << "the heated one pulls";
  EXPECT_GT(pair.second().truth().strain, rest);
  // Both at once, and in turn: loops inside of loops.
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 60; ++k) {
      pair.run(i % 2 == 0 ? 0.16 : 0, i % 3 == 0 ? 0.16 : 0, 1);
      check();
    }
  }
}

TEST_P(SimPairs, AForceFromOutsideSharesOut) {
  Antagonists pair(GetParam());
  pair.run(0, 0, 10);
  const double before_N = pair.first_N();
  pair.first().surroundings.added_stress_Pa = 20e6;
  pair.run(0, 0, 10);
  const double outside_N = pair.first_N() - pair.second_N();
  EXPECT_NEAR(outside_N, 20e6 / 150e6 * before_N, 1e-6);
  EXPECT_GT(pair.first_N(), before_N);
  EXPECT_LT(pair.second_N(), before_N);
}

TEST_P(SimPairs, ABrokenWireLetsTheOtherGo) {
  Antagonists pair(GetParam());
  pair.run(0.1, 0, 100);
  pair.second().faults().circuit = hal::Circuit::broken;
  pair.run(0.1, 0, 10);
  EXPECT_EQ(pair.first_N(), 0);
  EXPECT_EQ(pair.second_N(), 0);
}

INSTANTIATE_TEST_SUITE_P(Plants, SimPairs, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "Sublayers" : "Lumped"; });

}  // namespace
}  // namespace smaservo::test::pair_test
