#include "host-sim/evaluate/runs/runs.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "firmware/bench/dice.hpp"
#include "host-sim/evaluate/runs/electronics.hpp"

namespace smaservo::evaluate {
namespace {

using Steps = std::vector<bench::DriveStep>;

void full_cycles(Steps& drive, int count) {
  for (int i = 0; i < count; ++i) {
    drive.push_back({1, 5});
    drive.push_back({0, 4});
  }
}

void shrinking_loops(Steps& drive, double center, double amplitude, double each_s, int loops) {
  for (int i = 0; i < loops; ++i) {
    drive.push_back({center + amplitude, each_s});
    drive.push_back({std::max(center - amplitude, 0.0), each_s});
    amplitude *= 0.85;
  }
}

void random_steps(Steps& drive, double seconds, bench::Dice& dice) {
  while (seconds > 5e-4) {
    // Durations are whole milliseconds, like the plant's steps.
    const double part_s = std::min(1e-3 * std::round(dice.uniform(300, 3000)), seconds);
    drive.push_back({dice.uniform(0, 1), part_s});
    seconds -= part_s;
  }
}

/// The `overheat_K` with which level 1 ends 12 K above the finish of the transformation at the
/// highest stress in these surroundings. Levels themselves are computed for the first stress and
/// for still air of 25 °C.
double overheat_K(const Wire<double>& wire, const bench::JouleScenario& joule) {
  const auto finish_K = [&](double stress_Pa) {
    const Isobar<double> m2a = isobar(wire.kinetics.m2a, stress_Pa);
    return m2a.start_K + 1 / m2a.per_K;
  };
  double first_Pa = 0;
  double highest_Pa = 0;
  if (const auto* spring = std::get_if<hal::SpringLoad>(&joule.load)) {
    first_Pa = spring->low_Pa;
    highest_Pa = spring->high_Pa;
  } else if (const auto* varying = std::get_if<hal::VaryingLoad>(&joule.load)) {
    first_Pa = varying->stress_Pa;
    highest_Pa = varying->stress_Pa + varying->amplitude_Pa;
  } else {
    first_Pa = highest_Pa = std::get<hal::ConstantLoad>(joule.load).stress_Pa;
  }
  const double above_ambient_K = finish_K(highest_Pa) + 12 - joule.ambient_K;
  return room_K + joule.draught * above_ambient_K - finish_K(first_Pa);
}

bench::JouleScenario still_room(const Wire<double>& wire, hal::Load load) {
  return {.ambient_K = room_K,
          .draught = 1,
          .overheat_K = 12,
          .min_current_A = 0.012,
          .rate_Hz = 1000,
          .record_from_s = 0,
          .drive = {},
          .load = load,
          .sensors = sensors(wire.geometry, 1, 1)};
}

bench::Scenario scenario(const bench::WireUnit& unit, std::string note, std::uint64_t seed,
                         bench::JouleScenario joule) {
  return {std::move(note), unit.wire,       seed, unit.scatter_K, unit.family,
          unit.structure,  std::move(joule)};
}

hal::Load constant(double low_MPa, double high_MPa, bench::Dice& dice) {
  return hal::ConstantLoad{MPa * dice.uniform(low_MPa, high_MPa)};
}

hal::Load spring(bench::Dice& dice) {
  return hal::SpringLoad{MPa * dice.uniform(100, 140), MPa * dice.uniform(220, 300), 0.04, 0.05};
}

hal::Load random_load(Condition condition, bench::Dice& dice) {
  switch (condition) {
    case Condition::spring:
      return spring(dice);
    case Condition::varying: {
      const double amplitude_MPa = dice.uniform(30, 70);
      return hal::VaryingLoad{MPa * dice.uniform(180, 220), MPa * amplitude_MPa, dice.uniform(3, 9),
                              MPa * 10, MPa * 100};
    }
    case Condition::light:
      return constant(10, 50, dice);
    case Condition::unknown_start:
      return constant(50, 400, dice);
    case Condition::hold_ripple:
    case Condition::gust:
      return dice.coin() ? spring(dice) : constant(100, 400, dice);
    case Condition::constant:
    case Condition::coarse:
      break;
  }
  return constant(100, 400, dice);
}

Steps random_drive(Condition condition, bench::Dice& dice) {
  Steps drive{{0, 1}};
  full_cycles(drive, 1);
  if (condition == Condition::hold_ripple) {
    const double hold = dice.uniform(0.62, 0.72);
    drive.push_back({hold, 3});
    drive.push_back({hold, 20, 0.5, 2});
    drive.push_back({0, 4});
    random_steps(drive, 10, dice);
    return drive;
  }
  if (condition == Condition::gust) {
    const double hold = dice.uniform(0.6, 0.75);
    const double draught = std::exp(dice.uniform(std::log(0.5), std::log(3)));
    drive.push_back({hold, 8});
    drive.push_back({.level = hold, .seconds = 10, .draught = draught});
    drive.push_back({hold, 10});
    drive.push_back({0, 4});
    return drive;
  }
  const double each_s = 1e-3 * std::round(dice.uniform(1000, 1500));
  shrinking_loops(drive, dice.uniform(0.55, 0.65), 0.4, each_s, 7);
  random_steps(drive, 26, dice);
  return drive;
}

void disturb(bench::JouleScenario& joule, bench::Dice& dice) {
  joule.ambient_K += dice.uniform(-10, 10);
  joule.draught = dice.uniform(0.8, 1.2);
  joule.sensors.resistance_gain = dice.coin() ? 1.01 : 0.99;
  joule.sensors.load_gain = 1 + dice.uniform(-0.01, 0.01);
}

}  // namespace

bench::Scenario calibration_run(const bench::WireUnit& unit, std::size_t index) {
  const double stress_MPa = calibration_stresses_MPa.at(index);
  bench::JouleScenario joule = still_room(unit.wire.wire, hal::ConstantLoad{MPa * stress_MPa});
  // The seed is far from those that units and test runs are likely to have.
  bench::Dice dice(unit.seed + 7919 * (index + 1));
  joule.sensors.load_gain = 1 + dice.uniform(-0.005, 0.005);
  joule.drive = {{0, 1}};
  full_cycles(joule.drive, 2);
  shrinking_loops(joule.drive, 0.55, 0.45, 1, 10);
  random_steps(joule.drive, 21, dice);
  return scenario(unit, fmt::format("{}, calibration at {} MPa", unit.wire.name, stress_MPa),
                  dice.seed(), std::move(joule));
}

bench::Scenario commissioning_run(const bench::WireUnit& unit) {
  bench::Dice dice(unit.seed + 104729);
  bench::JouleScenario joule = still_room(unit.wire.wire, constant(120, 250, dice));
  joule.sensors.load_gain = 1 + dice.uniform(-0.005, 0.005);
  joule.drive = {{0, 2}, {0.49, 5}, {0, 5}};
  for (int i = 0; i < 2; ++i) {
    for (const double level : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0}) {
      joule.drive.push_back({level, 3});
    }
    for (const double level : {0.7, 0.6, 0.5, 0.4, 0.3, 0.2}) {
      joule.drive.push_back({level, 2.5});
    }
    joule.drive.push_back({0, 1});
  }
  return scenario(unit, unit.wire.name + ", commissioning", dice.seed(), std::move(joule));
}

std::string_view condition_name(Condition condition) {
  switch (condition) {
    case Condition::constant:
      return "constant";
    case Condition::spring:
      return "spring";
    case Condition::varying:
      return "varying";
    case Condition::light:
      return "light";
    case Condition::unknown_start:
      return "unknown-start";
    case Condition::hold_ripple:
      return "hold-ripple";
    case Condition::gust:
      return "gust";
    case Condition::coarse:
      break;
  }
  return "coarse";
}

bench::Scenario test_run(const bench::WireUnit& unit, Condition condition, std::uint64_t seed,
                         bool disturbed) {
  bench::Dice dice(seed);
  bench::JouleScenario joule = still_room(unit.wire.wire, random_load(condition, dice));
  joule.drive = random_drive(condition, dice);
  joule.sensors.load_gain = 1 + dice.uniform(-0.005, 0.005);
  if (disturbed) {
    disturb(joule, dice);
  }
  joule.overheat_K = overheat_K(unit.wire.wire, joule);
  if (condition == Condition::unknown_start) {
    // The first heating begins at 1 s and takes one second, the first cooling begins at 6 s and
    // takes half a second.
    const bool heats = dice.coin();
    const double share = dice.uniform(0.2, 0.8);
    joule.record_from_s = 1e-3 * std::round(1e3 * (heats ? 1 + share : 6 + 0.5 * share));
  }
  if (condition == Condition::coarse) {
    joule.rate_Hz = 100;
    joule.sensors.bits = 12;
    // A board made for this wire: its converters reach just beyond what it needs.
    joule.sensors.current_full_scale_A = 0.25;
    joule.sensors.voltage_full_scale_V = 5;
  }
  return scenario(unit,
                  fmt::format("{}, {}{}, seed {}", unit.wire.name, condition_name(condition),
                              disturbed ? " disturbed" : "", seed),
                  dice.seed(), std::move(joule));
}

}  // namespace smaservo::evaluate
