#pragma once
// A data card that is filled in, and recordings for it.

#include <fmt/format.h>
#include <string>
#include <vector>

#include "tests/host-sim/program.hpp"
#include "tests/host-sim/recordings.hpp"

namespace smaservo::test {

/// The card of recordings.hpp's wire, 100 mm of 76 um. `changes` replace lines by their keys, or,
/// with an empty line, remove them.
inline std::string filled_card(
    const std::vector<std::pair<std::string, std::string>>& changes = {}) {
  std::string card = R"([data]
title = "a wire that is known by heart"
by = "A. Tester"
when = "2026-11-30"
licence = "CC0-1.0"
remarks = "none"
[wire]
maker = "unknown"
type = "unknown"
alloy = "unknown"
batch = "unknown"
preset = "unknown"
length_mm = 100
length_measured = "caliper"
diameter_um = 76
diameter_measured = "unknown"
cold_resistance_ohm = 22
cold_resistance_measured = "four wires, 5 mA, 20 degC"
cycles = 500
history = "unknown"
[load]
kind = "weight"
force_N = "per run"
measured = "balance"
[surroundings]
air_degC = 20
orientation = "vertical"
movement = "open"
[electronics]
rate_Hz = 10
current_bits = "unknown"
current_full_scale_A = "unknown"
voltage_bits = 16
voltage_full_scale_V = 10
four_wire = true
together = "unknown"
filter = "none"
[displacement]
sensor = "laser"
resolution_um = 1
zero = "unknown"
)";
  for (const auto& [key, line] : changes) {
    const std::size_t at = card.find("\n" + key + " = ") + 1;
    const std::size_t end = card.find('\n', at) + 1;
    card.replace(at, end - at, line.empty() ? "" : line + "\n");
  }
  return card;
}

/// A run with load and strain as a laboratory would have it.
inline std::string joule_file(double load_N = 0.68) {
  const test::Recording r;
  return csv({{"time_s", r.time_s},
              {"current_A", r.current_A},
              {"voltage_V", r.voltage_V},
              {"load_N", std::vector<double>(r.strain.size(), load_N)},
              {"strain_ref", r.strain}});
}

/// All files of a folder and their content.
inline std::vector<std::pair<std::string, std::string>> content_of(const std::string& folder) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    all.emplace_back(entry.path().lexically_relative(folder).string(),
                     entry.is_regular_file() ? file_text(entry.path()) : "");
  }
  std::ranges::sort(all);
  return all;
}

}  // namespace smaservo::test
