#pragma once
// Scenario of a device on a simulated wire: a TOML file with a [device] table, whose keys are in
// host-sim/simulate/README.md.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/bench/plant_setup.hpp"
#include "firmware/bench/scenario/command_program.hpp"
#include "firmware/bench/scenario/sim_event.hpp"
#include "firmware/settings.hpp"
#include "hal/sim/board.hpp"

namespace smaservo::bench {

/// A second wire that pulls against the first one.
struct PairSetup {
  PlantSetup plant;
  hal::SimSetup board;
  /// Whether a device of its own drives it the other way; else it is only stretched by the first.
  bool driven;
};

struct ClosedLoopScenario {
  std::string name;  ///< the file's name
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

/// Whether a scenario file has a [device] table, and so is a closed loop's. Throws UserError.
bool is_closed_loop(const std::filesystem::path& path);

/// Settings of the default wire for short heating: the current limit is four times the maker's
/// continuous current, with which the wire would not contract at room temperature.
Settings<double> standard_settings();

/// A closed loop with these settings: the default wire under 150 MPa, a good front end, no
/// commands.
ClosedLoopScenario standard_closed_loop(const Settings<double>& settings);

/// Throws ConfigError, which names file, line, key, value and what is allowed.
ClosedLoopScenario load_closed_loop(const std::filesystem::path& path);

}  // namespace smaservo::bench
