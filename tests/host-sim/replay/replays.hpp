#pragma once
// Replays of the shipped traces, as a test asks for them.

#include <filesystem>
#include <string>
#include <vector>

#include "host-sim/replay/replay.hpp"
#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/host-sim/replay/trace_numbers.hpp"
#include "tests/places.hpp"

namespace smaservo::test {

inline std::string shipped(const std::string& name) {
  return (std::filesystem::path(test::source_folder()) / "host-sim/traces" / name).string();
}

inline replay::ReplayOptions replay_options(const std::string& trace, const std::string& unit,
                                            const std::string& out = "") {
  replay::ReplayOptions options;
  options.trace = trace;
  options.wire = files::load_wire(shipped("units/" + unit + ".toml"));
  options.out = out;
  return options;
}

struct Estimated {
  replay::ReplayResult result;
  std::string text;  ///< the estimate's file
  NumberTable table;

  const std::vector<double>& column(const std::string& name) const {
    const auto found = std::ranges::find(table.names, name);
    return table.columns.at(static_cast<std::size_t>(found - table.names.begin()));
  }
};

/// A replay with its estimate.
inline Estimated estimated(replay::ReplayOptions options) {
  const TemporaryFolder folder;
  options.out = folder / "estimate.csv";
  Estimated e{replay::replay(options), file_text(options.out), {}};
  e.table = parse_numbers(e.text);
  return e;
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
  }
  return lines;
}

inline std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) {
    text += line + "\n";
  }
  return text;
}

/// Header and first rows of a shipped trace.
inline std::vector<std::string> first_lines(const std::string& trace, std::size_t rows) {
  std::vector<std::string> lines = lines_of(file_text(shipped(trace)));
  lines.resize(std::min(lines.size(), rows + 1));
  return lines;
}

}  // namespace smaservo::test
