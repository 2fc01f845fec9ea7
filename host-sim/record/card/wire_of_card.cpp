#include "host-sim/record/card/wire_of_card.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "host-sim/record/card/card_keys.hpp"
#include "model/files/error.hpp"

namespace smaservo::record {
namespace {

/// "120 mm, caliper from clamp to clamp": what the card says of a number.
std::string source_of(const Card& card, const std::string& path) {
  const std::string how = card.word(path + "_measured");
  const std::string shown = card.values.find(path)->second.shown;
  return how == unknown_word || how.empty()
             ? fmt::format("data card: {}, nobody knows how it was measured", shown)
             : fmt::format("data card: {}, {}", shown, how);
}

void set_source(files::WireDescription& wire, const std::string& key, const std::string& text) {
  const auto found =
      std::ranges::find(wire.sources, key, &std::pair<std::string, std::string>::first);
  if (found == wire.sources.end()) {
    wire.sources.emplace_back(key, text);
  } else {
    found->second = text;
  }
}

}  // namespace

std::string preset_of(const Card& card) {
  std::string given = card.word("wire.preset");
  if (given != unknown_word && !given.empty()) {
    return given;
  }
  const double wanted_m = card.number("wire.diameter").value_or(0);
  // The family of the default wire comes first where several have this diameter.
  std::vector<std::string> names = files::preset_names();
  const std::string_view family = files::default_wire.substr(0, files::default_wire.find('-') + 1);
  std::ranges::sort(names, {}, [&](const std::string& name) {
    return std::pair(!name.starts_with(family), name);
  });
  constexpr double same = 0.005;
  double nearest = std::numeric_limits<double>::infinity();
  std::string best;
  for (const std::string& name : names) {
    const double away =
        std::abs(std::log(files::load_wire(name).wire.geometry.diameter_m / wanted_m));
    if (away < nearest - same) {
      nearest = away;
      best = name;
    }
  }
  if (best.empty()) {
    throw files::UserError(
        fmt::format("{}: has neither wire.preset nor wire.diameter", card.origin));
  }
  return best;
}

files::WireDescription wire_of(const Card& card) {
  const std::string preset = preset_of(card);
  std::vector<files::Override> changes;
  for (const char* const path : {"wire.length", "wire.diameter"}) {
    if (card.number(path)) {
      const CardValue& value = card.values.find(path)->second;
      changes.emplace_back(value.key, value.written);
    }
  }
  const auto ohm = card.number("wire.cold_resistance"), length_m = card.number("wire.length");
  if (ohm && length_m) {
    changes.emplace_back("wire.resistance_ohm_per_m", fmt::format("{}", *ohm / *length_m));
  }
  files::WireDescription wire;
  try {
    wire = files::load_wire(preset, changes);
  } catch (const files::ConfigError& error) {
    throw files::UserError(
        fmt::format("{}: makes no wire of {}: {}", card.origin, preset, error.what()));
  }
  wire.name = fmt::format("{}, {}", preset, card.values.find("wire.length")->second.shown);
  set_source(wire, "wire.length", source_of(card, "wire.length"));
  if (card.number("wire.diameter")) {
    set_source(wire, "wire.diameter", source_of(card, "wire.diameter"));
  }
  if (ohm) {
    set_source(wire, "wire.resistance", source_of(card, "wire.cold_resistance"));
  }
  return wire;
}

}  // namespace smaservo::record
