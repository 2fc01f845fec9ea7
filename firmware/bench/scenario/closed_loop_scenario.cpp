#include "firmware/bench/scenario/closed_loop_scenario.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "firmware/bench/scenario/scenario_tables.hpp"
#include "firmware/text/settings_file.hpp"
#include "model/units.hpp"

namespace smaservo::bench {
namespace {

constexpr double MPa = 1e6;
constexpr std::array<std::string_view, 2> drive_names{"current", "voltage"};
constexpr std::array<std::string_view, 2> pair_names{"driven", "passive"};

Settings<double> read_device(const files::TomlFile& file, files::TomlTable table) {
  const std::string path = file.beside(table.text("settings"));
  std::vector<files::Override> changed;
  if (table.has("set")) {
    changed = text::parse_settings(table.texts("set"));
  }
  table.finish();
  return text::load_settings_file(path, changed);
}

/// Reads the sensors; keys that are left out have the values of a good front end for this device.
hal::Sensors read_sensors(files::TomlTable table, const Settings<double>& settings) {
  const MeasurementSettings<double>& m = settings.measurement;
  const double area_m2 = settings.wire.geometry.area_m2();
  hal::Sensors s{};
  s.bits = static_cast<int>(table.number("bits", 8, 32, 16));
  s.current_full_scale_A =
      1e-3 * table.number("current_full_scale_mA", 1, 1e5, 1e3 * m.current_full_scale_A);
  s.voltage_full_scale_V = table.number("voltage_full_scale_V", 0.1, 1000, m.voltage_full_scale_V);
  s.load_full_scale_N = table.number("load_full_scale_N", 0.01, 1e5, 1100 * MPa * area_m2);
  s.current_noise_A = 1e-6 * table.number("current_noise_uA", 0, 1e6, 1e6 * m.current_noise_A);
  s.voltage_noise_V = 1e-3 * table.number("voltage_noise_mV", 0, 1e3, 1e3 * m.voltage_noise_V);
  s.load_noise_N = 1e-3 * table.number("load_noise_mN", 0, 1e6, 1e3 * 0.5 * MPa * area_m2);
  s.load_gain = 1 + 0.01 * table.number("load_gain_error_percent", -50, 50, 0);
  s.resistance_gain = 1 + 0.01 * table.number("resistance_drift_percent", -20, 20, 0);
  table.finish();
  return s;
}

hal::Converter read_converter(files::TomlTable table, const Settings<double>& settings,
                              hal::SimSetup& board) {
  hal::Converter c{};
  const std::size_t kind = table.has("type") ? table.choice("type", drive_names)
                                             : static_cast<std::size_t>(settings.drive.kind);
  c.voltage_drive = kind == 1;
  c.max_A = 1e-3 * table.number("max_mA", 1, 1e5, 1e3 * settings.measurement.current_full_scale_A);
  c.slew_A_s = table.number("slew_A_s", 0.01, 1e6, std::numeric_limits<double>::infinity());
  c.lead_ohm = table.number("lead_ohm", 0, 1e4, 0.2);
  board.surroundings.supply_V = table.number("supply_V", 0.1, 1000, 24);
  table.finish();
  return c;
}

hal::SimSetup read_board(files::TomlTable& root, files::TomlTable& plant,
                         const ClosedLoopScenario& scenario) {
  hal::SimSetup board{};
  board.period_ns = std::llround(scenario.settings.timing.period_s * 1e9);
  board.converter = read_converter(root.table_or_empty("drive"), scenario.settings, board);
  board.sensors = read_sensors(root.table_or_empty("sensors"), scenario.settings);
  board.load =
      root.has("load") ? read_load(root.table("load")) : hal::Load{hal::ConstantLoad{150 * MPa}};
  board.geometry = scenario.plant.wire.wire.geometry;
  board.surroundings.ambient_K = zero_degC_K + plant.number("ambient_degC", -40, 80, 25);
  board.surroundings.draught = plant.number("draught", 0.1, 10, 1);
  board.reads_supply = board.reads_driver = true;
  board.reads_ambient = false;
  board.seed = scenario.seed;
  return board;
}

PairSetup read_pair(files::TomlTable table, const ClosedLoopScenario& scenario) {
  PairSetup pair{scenario.plant, scenario.board, table.choice("type", pair_names) == 0};
  // The second wire is another piece of the same kind. Both are at rest under the first one's load.
  pair.plant.seed = scenario.plant.seed + 7919;
  pair.board.seed = scenario.board.seed + 7919;
  if (!std::holds_alternative<hal::ConstantLoad>(scenario.board.load)) {
    table.fail("type",
               "a pair needs a constant load ([load] type = 'constant'): its force at rest");
  }
  table.finish();
  return pair;
}

}  // namespace

bool is_closed_loop(const std::filesystem::path& path) {
  return files::TomlFile(path).root().has("device");
}

Settings<double> standard_settings() {
  Settings<double> settings =
      text::settings_for(files::load_wire(std::string(files::default_wire)).wire);
  settings.measurement.current_full_scale_A = 0.5;
  settings.limits.min_current_A = 0.02;
  settings.limits.current_A = 0.4;
  settings.limits.power_W = 10;
  settings.limits.stress_Pa = 300e6;
  settings.trips.current_A = 0.45;
  settings.trips.stress_Pa = 400e6;
  settings.trips.min_strain = -0.005;
  settings.trips.max_strain = 0.07;
  return stored_settings<double>(settings);
}

ClosedLoopScenario standard_closed_loop(const Settings<double>& settings) {
  static const toml::table empty;
  const std::string name = "standard";
  files::TomlTable root(empty, "", name);
  files::TomlTable plant(empty, "", name);
  ClosedLoopScenario scenario{};
  scenario.name = name;
  scenario.seed = 1;
  scenario.settings = settings;
  scenario.plant = {
      PlantFamily::ihyp, files::load_wire(std::string(files::default_wire)), 0.5, {}, 1};
  scenario.board = read_board(root, plant, scenario);
  return scenario;
}

ClosedLoopScenario load_closed_loop(const std::filesystem::path& path) {
  const files::TomlFile file(path);
  files::TomlTable root = file.root();
  ClosedLoopScenario scenario{};
  scenario.name = path.string();
  scenario.note = root.text("note");
  scenario.seed = static_cast<std::uint64_t>(root.number("seed", 0, 1e9, 1));
  scenario.settings = read_device(file, root.table("device"));
  files::TomlTable plant = root.table_or_empty("plant");
  scenario.plant = read_plant(file, plant, scenario.seed);
  std::mt19937_64 random(scenario.seed + 3);
  scenario.program = read_commands(root.tables("command"), random);
  scenario.board = read_board(root, plant, scenario);
  plant.finish();
  if (root.has("pair")) {
    scenario.pair = read_pair(root.table("pair"), scenario);
  }
  if (root.has("event")) {
    scenario.events = read_events(root.tables("event"));
    const bool has_stop = std::ranges::any_of(
        scenario.events, [](const SimEvent& event) { return event.stop_strain.has_value(); });
    if (has_stop && scenario.pair) {
      root.fail("event", "stop_percent: not in a pair, whose wires hold each other");
    }
  }
  scenario.duration_s =
      root.number("duration_s", 0.01, longest_s, CommandProgram(scenario.program).duration_s());
  root.finish();
  return scenario;
}

}  // namespace smaservo::bench
