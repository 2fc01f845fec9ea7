#include "firmware/bench/scenario/scenario.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "firmware/bench/scenario/scenario_tables.hpp"
#include "model/units.hpp"

namespace smaservo::bench {

hal::Load read_load(files::TomlTable table) {
  const std::string type = table.text("type");
  hal::Load load;
  if (type == "constant") {
    load = hal::ConstantLoad{1e6 * table.number("stress_MPa", 0, 1000)};
  } else if (type == "spring") {
    load = hal::SpringLoad{1e6 * table.number("low_MPa", 0, 1000),
                           1e6 * table.number("high_MPa", 0, 1000),
                           table.number("stroke", 0.001, 0.2), table.number("lag_s", 0.01, 10)};
  } else if (type == "varying") {
    load = hal::VaryingLoad{
        1e6 * table.number("stress_MPa", 0, 1000), 1e6 * table.number("amplitude_MPa", 0, 1000),
        table.number("period_s", 0.1, 1000), 1e6 * table.number("walk_MPa", 0, 1000, 0),
        1e6 * table.number("min_MPa", 0, 1000)};
  } else {
    table.fail("type", "must be one of: constant, spring, varying");
  }
  table.finish();
  return load;
}

namespace {

constexpr double longest_run_s = 1e5;

hal::Family read_family(files::TomlTable& table) {
  if (!table.has("family")) {
    return hal::Family::ihyp;
  }
  std::array<std::string_view, hal::families.size()> names;
  std::ranges::transform(hal::families, names.begin(), hal::family_name);
  return hal::families[table.choice("family", names)];
}

DriveStep read_level(files::TomlTable& table) {
  DriveStep step{table.number("level", 0, 2), table.number("for_s", 0.001, longest_run_s)};
  if (table.has("ripple")) {
    step.ripple = table.number("ripple", 0, 1);
    step.ripple_Hz = table.number("ripple_Hz", 0.01, 100);
  }
  if (table.has("draught")) {
    step.draught = table.number("draught", 0.1, 10);
  }
  return step;
}

std::vector<DriveStep> read_drive(std::vector<files::TomlTable> tables, std::mt19937_64& random) {
  std::vector<DriveStep> drive;
  for (files::TomlTable& step : tables) {
    if (step.has("level")) {
      drive.push_back(read_level(step));
    } else if (step.has("shrinking")) {
      const double center = step.number("center", 0, 2);
      double amplitude = step.number("shrinking", 0, 1);
      const double factor = step.number("factor", 0, 1);
      const double each_s = step.number("each_s", 0.001, longest_run_s);
      const double loops = step.number("loops", 1, 1e4);
      for (double i = 0; i < loops; ++i) {
        drive.push_back({center + amplitude, each_s});
        drive.push_back({std::max(center - amplitude, 0.0), each_s});
        amplitude *= factor;
      }
    } else if (step.has("random")) {
      const auto [low, high] = step.range("random", 0, 2);
      const auto [shortest_s, longest_s] = step.range("each_s", 0.001, longest_run_s);
      std::uniform_real_distribution<double> level(low, high);
      std::uniform_real_distribution<double> seconds(shortest_s, longest_s);
      double left_s = step.number("for_s", 0.001, longest_run_s);
      while (left_s > 0) {
        const double part_s = std::min(seconds(random), left_s);
        drive.push_back({level(random), part_s});
        left_s -= part_s;
      }
    } else {
      step.fail("level", "is missing; give one of level, shrinking, random");
    }
    step.finish();
  }
  return drive;
}

hal::Sensors read_sensors(files::TomlTable table) {
  hal::Sensors s{static_cast<int>(table.number("bits", 8, 32)),
                 1e-3 * table.number("current_full_scale_mA", 1, 1e5),
                 table.number("voltage_full_scale_V", 0.1, 1000),
                 table.number("load_full_scale_N", 0.01, 1e5),
                 1e-6 * table.number("current_noise_uA", 0, 1e6),
                 1e-3 * table.number("voltage_noise_mV", 0, 1e3),
                 1e-3 * table.number("load_noise_mN", 0, 1e6),
                 1 + 0.01 * table.number("load_gain_error_percent", -50, 50),
                 1 + 0.01 * table.number("resistance_drift_percent", -20, 20)};
  table.finish();
  return s;
}

}  // namespace

Scenario load_scenario(const std::filesystem::path& file) {
  const files::TomlFile parsed(file);
  files::TomlTable root = parsed.root();
  Scenario scenario{};
  scenario.note = root.text("note");
  const std::string wire = root.text("wire");
  scenario.wire = files::load_wire(wire.ends_with(".toml") ? parsed.beside(wire) : wire);
  scenario.seed = static_cast<std::uint64_t>(root.number("seed", 0, 1e9));
  scenario.scatter_K = root.number("scatter_K", 0, 20);
  scenario.family = read_family(root);
  std::mt19937_64 random(scenario.seed);
  if (root.has("bath")) {
    files::TomlTable bath = root.table("bath");
    BathScenario b{1e6 * bath.number("stress_MPa", 0, 1000), bath.number("step_K", 0.01, 10),
                   bath.numbers("turning_degC", -50, 250),
                   bath.number("temperature_noise_K", 0, 5)};
    for (double& turning : b.turning_K) {
      turning += zero_degC_K;
    }
    bath.finish();
    scenario.run = b;
  } else {
    files::TomlTable joule = root.table("joule");
    JouleScenario j{zero_degC_K + joule.number("ambient_degC", -40, 80),
                    joule.number("draught", 0.1, 10),
                    joule.number("overheat_K", 0, 100),
                    1e-3 * joule.number("min_current_mA", 0, 1e4),
                    joule.number("rate_Hz", 1, 1000),
                    joule.number("record_from_s", 0, longest_run_s, 0),
                    read_drive(joule.tables("drive"), random),
                    read_load(joule.table("load")),
                    read_sensors(joule.table("sensors"))};
    if (std::abs(1000 / j.rate_Hz - std::round(1000 / j.rate_Hz)) > 1e-9) {
      joule.fail("rate_Hz", "must divide 1000: the plant runs at 1 kHz");
    }
    joule.finish();
    scenario.run = j;
  }
  root.finish();
  return scenario;
}

}  // namespace smaservo::bench
