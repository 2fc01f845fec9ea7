#pragma once
// A device on a simulated wire, and what is asked of both: a TOML file with a [device] table,
// host-sim/simulate/README.md has the keys.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/bench/command_program.hpp"
#include "firmware/bench/plant_setup.hpp"
#include "firmware/bench/sim_event.hpp"
#include "firmware/settings.hpp"
#include "hal/sim/board.hpp"

namespace smaservo::bench {

/// A second wire against the first one.
struct PairSetup {
  PlantSetup plant;
  hal::SimSetup board;
  bool driven;  ///< by a device of its own that goes the other way; else it is only pulled
};

struct ClosedLoopScenario {
  std::string name;  ///< the file's
  std::string note;
  std::uint64_t seed;
  double duration_s;
  Settings<double> settings;
  PlantSetup plant;
  hal::SimSetup board;
  std::optional<PairSetup> pair;
  std::vector<CommandStretch> program;
  std::vector<SimEvent> events;
};

/// Whether a scenario file is one of these: it has a [device] table. Throws UserError.
bool is_closed_loop(const std::filesystem::path& path);

/// The default wire's settings for short heating: four times its maker's continuous current, with
/// which it would not contract in a room.
Settings<double> standard_settings();

/// This device on a wire of the default kind, with a good front end, under 150 MPa, without a
/// program.
ClosedLoopScenario standard_closed_loop(const Settings<double>& settings);

/// Throws ConfigError: names file, line, key, value and what is allowed.
ClosedLoopScenario load_closed_loop(const std::filesystem::path& path);

}  // namespace smaservo::bench
