#include "host-sim/fmu/fmu_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/text/settings_file.hpp"
#include "host-sim/fmu/unit/check.hpp"
#include "host-sim/fmu/unit/servo_variables.hpp"
#include "host-sim/fmu/zip_file.hpp"
#include "model/files/error.hpp"
#include "model/files/installed.hpp"
#include "model/files/output_file.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::fmu {
namespace {

namespace fs = std::filesystem;

constexpr double start_stress_Pa = 100e6;
constexpr double wire_step_s = 1e-3;
constexpr double supply_V = 24;

/// A folder of shared libraries, with the names that FMI has for its platform.
struct Platform {
  const char *folder, *fmi2, *fmi3;
};
/// FMI 2 names no Linux on Arm; simulators that run there look for FMI 3's name.
constexpr std::array platforms{Platform{"x86_64-linux", "linux64", "x86_64-linux"},
                               Platform{"aarch64-linux", "aarch64-linux", "aarch64-linux"},
                               Platform{"aarch32-linux", "aarch32-linux", "aarch32-linux"}};

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    throw files::UserError(fmt::format(
        "{}: cannot be read; the package smaservo brings it, a build makes it as target "
        "smaservo_fmu. host-sim looks in ../lib/smaservo/fmu beside itself: do not move "
        "the program alone",
        path.string()));
  }
  return text;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

fs::path folder() {
  return files::installed("fmu");
}

const char* kind_name(Kind kind) {
  return kind == Kind::wire ? "wire" : "servo";
}

/// All files below the folder sources.
std::vector<std::string> source_files(Kind kind) {
  return lines_of(content_of(folder() / "sources" / (std::string(kind_name(kind)) + ".txt")));
}

void add_surfaces(Description& d, const std::string& before, const Wire<double>& wire) {
  d.constants.emplace_back(before + "separate_r2a", wire.kinetics.separate_r2a ? 1 : 0);
  d.constants.emplace_back(before + "separate_r2m", wire.kinetics.separate_r2m ? 1 : 0);
}

double load_of(const ExportOptions& options, const Wire<double>& wire) {
  return options.load_N.value_or(start_stress_Pa * wire.geometry.area_m2());
}

/// A wire file may write a number in a way whose SI value is out of the row's range.
void check_values(const Description& d) {
  for (std::size_t i = 0; i < d.variables.size(); ++i) {
    const unit::Variable& v = d.variables[i];
    if (v.role == unit::Role::parameter || v.role == unit::Role::input) {
      const std::string problem = unit::wrong_value(v, d.start[i]);
      if (!problem.empty()) {
        throw files::UserError(fmt::format("{}: {}", d.name, problem));
      }
    }
  }
}

void describe_wire(const ExportOptions& options, Description& d) {
  const Wire<double> wire = files::load_wire(options.wire, options.overrides).wire;
  add_surfaces(d, "", wire);
  d.variables = unit::wire_variables(unit::surfaces_of(wire));
  d.step_s = wire_step_s;
  d.start.assign(unit::wire_inputs_at, 0);
  d.start.insert(d.start.end(), {0, load_of(options, wire), room_K, 1});
  d.start.resize(unit::wire_parameters_at);
  unit::append_wire(d.start, wire);
}

std::vector<files::Override> of_wire(const std::vector<files::Override>& overrides) {
  std::vector<files::Override> result;
  std::ranges::copy_if(overrides, std::back_inserter(result), [](const files::Override& override) {
    return override.first.starts_with("wire.");
  });
  return result;
}

void append_board(std::vector<double>& values, const Settings<double>& settings) {
  // The sensors and the output stage that `simulate` assumes for a device.
  const hal::SimSetup board = bench::standard_closed_loop(settings).board;
  constexpr double fastest_A_s = 1e6;
  values.insert(
      values.end(),
      {static_cast<double>(board.sensors.bits), board.sensors.current_full_scale_A,
       board.sensors.voltage_full_scale_V, board.sensors.load_full_scale_N,
       board.sensors.current_noise_A, board.sensors.voltage_noise_V, board.sensors.load_noise_N,
       board.sensors.load_gain, board.sensors.resistance_gain, static_cast<double>(board.seed),
       board.reads_supply ? 1.0 : 0.0, board.reads_ambient ? 1.0 : 0.0,
       board.reads_driver ? 1.0 : 0.0, board.surroundings.driver_above_K, board.converter.max_A,
       std::min(board.converter.slew_A_s, fastest_A_s), board.converter.lead_ohm});
}

void describe_servo(const ExportOptions& options, Description& d) {
  const Wire<double> given = options.wire.empty()
                                 ? Wire<double>{}
                                 : files::load_wire(options.wire, of_wire(options.overrides)).wire;
  const Settings<double> settings =
      options.settings.empty()
          ? text::parse_settings_file(text::to_toml(stored_settings<double>(
                                          text::settings_for(files::load_wire(options.wire).wire))),
                                      options.wire, options.overrides)
          : text::load_settings_file(options.settings, options.overrides);
  const Wire<double>& wire = options.wire.empty() ? settings.wire : given;
  add_surfaces(d, "", settings.wire);
  add_surfaces(d, "true.", wire);
  d.variables = unit::servo_variables(unit::surfaces_of(settings.wire), unit::surfaces_of(wire));
  // The device counts whole nanoseconds; 1 ms is not exact as a float.
  d.step_s = std::round(settings.timing.period_s * 1e9) / 1e9;
  d.start.assign(unit::servo_parameters_at, 0);
  const auto input = [&](unit::ServoInput which) -> double& {
    return d.start[unit::servo_inputs_at + static_cast<std::size_t>(which)];
  };
  input(unit::ServoInput::enable) = 1;
  input(unit::ServoInput::load_N) = load_of(options, wire);
  input(unit::ServoInput::ambient_K) = room_K;
  input(unit::ServoInput::draught) = 1;
  input(unit::ServoInput::supply_V) = supply_V;
  unit::append_settings(d.start, settings);
  append_board(d.start, settings);
  unit::append_wire(d.start, wire);
}

/// For those who compile the sources by hand: of a simulator on Windows or macOS.
std::string cmake_of(const Description& d) {
  std::string all = fmt::format(
      "# cmake -S . -B build && cmake --build build --config Release\n"
      "cmake_minimum_required(VERSION 3.16)\nproject({0} LANGUAGES CXX)\n"
      "set(CMAKE_CXX_STANDARD 20)\nset(CMAKE_CXX_STANDARD_REQUIRED ON)\n"
      "if(NOT CMAKE_BUILD_TYPE)\n  set(CMAKE_BUILD_TYPE Release)\nendif()\n"
      "add_library({0} MODULE\n",
      identifier(d.kind));
  for (const std::string& source : d.sources) {
    all += "  " + source + '\n';
  }
  return all +
         fmt::format(
             "  )\ntarget_include_directories({0} PRIVATE \"${{CMAKE_CURRENT_SOURCE_DIR}}\")\n"
             "set_target_properties({0} PROPERTIES PREFIX \"\" CXX_VISIBILITY_PRESET hidden\n"
             "  VISIBILITY_INLINES_HIDDEN ON)\n"
             "if(NOT MSVC)\n  # One rounding for each operation, as in the libraries inside.\n"
             "  target_compile_options({0} PRIVATE -ffp-contract=off)\nendif()\n",
             identifier(d.kind));
}

}  // namespace

Description describe(const ExportOptions& options) {
  Description d{};
  d.kind = options.kind;
  d.name = options.wire.empty() ? options.settings : options.wire;
  if (options.kind == Kind::wire) {
    describe_wire(options, d);
  } else {
    describe_servo(options, d);
  }
  check_values(d);
  for (const std::string& file : source_files(options.kind)) {
    if (file.ends_with(".cpp")) {
      d.sources.push_back(file);
    }
  }
  return d;
}

Written write_fmu(const Description& description, Version version, const std::string& out) {
  const bool two = version == Version::fmi2;
  const std::string name = identifier(description.kind);
  const fs::path from = folder();
  Written written{};
  std::vector<std::pair<std::string, std::string>> contents{
      {"modelDescription.xml", model_description(description, version)},
      {"resources/values.txt", values_file(description, version)},
      {"documentation/index.html", documentation(description)},
      {"documentation/licenses/license.txt",
       content_of(from / (std::string(kind_name(description.kind)) + "-license.txt"))},
      {"sources/CMakeLists.txt", cmake_of(description)}};
  if (!two) {
    contents.emplace_back("sources/buildDescription.xml", build_description(description));
  }
  for (const Platform& platform : platforms) {
    const fs::path library = from / platform.folder / (name + ".so");
    if (fs::exists(library)) {
      written.platforms.emplace_back(two ? platform.fmi2 : platform.fmi3);
      contents.emplace_back(fmt::format("binaries/{}/{}.so", written.platforms.back(), name),
                            content_of(library));
    }
  }
  for (const std::string& file : source_files(description.kind)) {
    contents.emplace_back("sources/" + file, content_of(from / "sources" / file));
  }
  std::ranges::sort(contents);
  ZipFile zip;
  for (const auto& [file, content] : contents) {
    zip.add(file, content);
  }
  const std::string bytes = zip.finish();
  files::OutputFile file(out);
  file.write(bytes);
  file.commit();
  written.bytes = bytes.size();
  const auto count = [&](unit::Role role) {
    return static_cast<std::size_t>(
        std::ranges::count(description.variables, role, &unit::Variable::role));
  };
  written.parameters = count(unit::Role::parameter);
  written.inputs = count(unit::Role::input);
  written.outputs = count(unit::Role::output);
  return written;
}

}  // namespace smaservo::fmu
