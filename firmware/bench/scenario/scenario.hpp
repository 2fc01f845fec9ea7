#pragma once
// Scenario of a wire without a device, for `simulate`: a TOML file, whose keys are in
// host-sim/simulate/README.md.

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "hal/sim/simulated_bench.hpp"
#include "hal/sim/simulated_wire.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::bench {

/// Heating power as a level: 0 keeps the wire at ambient temperature; at 1 it ends up fully
/// transformed and `overheat_K` warmer than that needs.
struct DriveStep {
  double level;
  double seconds;
  double ripple = 0;  ///< amplitude of a sine on the power, as a share of it, 0..1
  double ripple_Hz = 0;
  double draught = 1;  ///< factor on the convection, reached with a time constant of 0.1 s
};

/// A wire heated by a current, measured electrically.
struct JouleScenario {
  double ambient_K;
  double draught;  ///< factor on still-air convection
  double overheat_K;
  double min_current_A;
  double rate_Hz;
  double record_from_s;
  std::vector<DriveStep> drive;
  hal::Load load;
  hal::Sensors sensors;
};

/// A wire in a bath whose temperature and load are set.
struct BathScenario {
  double stress_Pa;
  double step_K;
  std::vector<double> turning_K;
  double temperature_noise_K;
};

struct Scenario {
  std::string note;
  files::WireDescription wire;
  std::uint64_t seed;
  double scatter_K;  ///< standard deviation of the transition temperatures along the wire
  hal::Family family = hal::Family::ihyp;
  hal::Structure structure;  ///< of the family
  std::variant<JouleScenario, BathScenario> run;
};

/// Throws UserError, which names file, key, value and what is allowed.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace smaservo::bench
