#pragma once
// What `simulate` does to a wire: a TOML file, host-sim/README.md has the keys.

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "host-sim/simulated_wire.hpp"
#include "model/wires/wire_file.hpp"

namespace smaservo {

/// Load on the wire.
struct ConstantLoad {
  double stress_Pa;
};
struct SpringLoad {
  double low_Pa, high_Pa;  ///< stress on the long and on the short wire
  double stroke;           ///< strain between the two
  double lag_s;            ///< of the mass that moves along
};
struct VaryingLoad {
  double stress_Pa, amplitude_Pa, period_s;
  double walk_Pa;  ///< per square root of a second, pulled back within 3 s
  double least_Pa;
};
using Load = std::variant<ConstantLoad, SpringLoad, VaryingLoad>;

/// Heating power by level: 0 keeps the wire at ambient temperature, 1 would end where it is fully
/// transformed and `overheat` warmer.
struct DriveStep {
  double level;
  double seconds;
  double ripple = 0;  ///< sinus on the power, as a share of it, 0..1
  double ripple_Hz = 0;
};

struct Sensors {
  int bits;
  double current_full_scale_A, voltage_full_scale_V, load_full_scale_N;
  double current_noise_A, voltage_noise_V, load_noise_N;
  double load_gain;
  double resistance_gain;  ///< what the wire's resistance has drifted by
};

/// A wire heated by a current, measured electrically.
struct JouleScenario {
  double ambient_K;
  double draught;  ///< factor on still-air convection
  double overheat_K;
  double least_current_A;
  double rate_Hz;
  double record_from_s;
  std::vector<DriveStep> drive;
  Load load;
  Sensors sensors;
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
  WireDescription wire;
  std::uint64_t seed;
  double scatter_K;  ///< standard deviation of the transition temperatures along the wire
  Family family = Family::ihyp;
  SublayerStructure sublayers;  ///< of that family only
  std::variant<JouleScenario, BathScenario> run;
};

/// Throws UserError or WireError: names file, key, value and what is allowed.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace smaservo
