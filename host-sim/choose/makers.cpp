#include "host-sim/choose/makers.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::choose {
namespace {

struct FlexinolRow {
  std::string_view size;
  double stretching_gf;  ///< the maker's "cooling deformation force"
  double lt_s, ht_s;     ///< the maker's "cooling time"
};
constexpr auto flexinol = std::to_array<FlexinolRow>({
    {"0.025mm", 3.6, 0.18, 0.15},
    {"0.038mm", 8, 0.24, 0.20},
    {"0.050mm", 14, 0.4, 0.3},
    {"0.076mm", 32, 0.8, 0.7},
    {"0.10mm", 57, 1.1, 0.9},
    {"0.13mm", 89, 1.6, 1.4},
    {"0.15mm", 128, 2.0, 1.7},
    {"0.20mm", 228, 3.2, 2.7},
    {"0.25mm", 356, 5.4, 4.5},
    {"0.31mm", 512, 8.1, 6.8},
    {"0.38mm", 900, 10.5, 8.8},
    {"0.51mm", 1424, 16.8, 14.0},
});

struct SmartFlexRow {
  std::string_view size;
  double suggested_N;  ///< the maker's "suggested operating force"
};
constexpr auto smartflex = std::to_array<SmartFlexRow>({
    {"25um", 0.1},
    {"50um", 0.3},
    {"76um", 0.8},
    {"100um", 1.3},
    {"150um", 2.7},
    {"200um", 5},
    {"300um", 12},
    {"400um", 21},
    {"500um", 33},
});

constexpr double N_per_gf = 9.80665e-3;
/// SmartFlex's maker states no force that stretches the wire. It is the same kind of alloy, so this
/// is Flexinol's.
constexpr double stretching_Pa = 70e6;

template <class Rows>
const auto& row_of(const Rows& rows, const std::string& preset) {
  const auto found = std::ranges::find_if(
      rows, [&](const auto& row) { return preset.ends_with("-" + std::string(row.size)); });
  if (found == rows.end()) {
    throw std::logic_error(preset + ": add this wire to host-sim/choose/makers.cpp");
  }
  return *found;
}

MakersWire makers_wire(const std::string& preset) {
  MakersWire m{preset, files::load_wire(preset).wire, 0, 0, {}, {}};
  const double area_m2 = m.wire.geometry.area_m2();
  if (preset.starts_with("flexinol")) {
    const FlexinolRow& row = row_of(flexinol, preset);
    m.suggested_load_N = m.wire.limits.stress_Pa * area_m2;
    m.stretching_load_N = row.stretching_gf * N_per_gf;
    m.current_1s_A = m.wire.limits.current_A;
    m.cooling_s = preset.starts_with("flexinol-lt") ? row.lt_s : row.ht_s;
  } else {
    m.suggested_load_N = row_of(smartflex, preset).suggested_N;
    m.stretching_load_N = stretching_Pa * area_m2;
  }
  return m;
}

}  // namespace

Life life_of(std::string_view name) {
  if (name != "long" && name != "short") {
    throw files::UserError(fmt::format("life = {}: must be long or short", files::printable(name)));
  }
  return name == "long" ? Life::many : Life::few;
}

double MakersWire::allowed_load_N(Life life) const {
  return life == Life::many ? suggested_load_N : wire.limits.stress_Pa * wire.geometry.area_m2();
}

double MakersWire::allowed_stroke(Life life, bool spring) const {
  if (life == Life::few) {
    return 0.05;
  }
  if (is_flexinol()) {
    return spring ? 0.03 : 0.04;
  }
  return 0.035;
}

std::string_view MakersWire::cycles(Life life) const {
  if (is_flexinol()) {
    return life == Life::many ? "a million" : "fewer";
  }
  return life == Life::many ? "many" : "few";
}

const std::vector<MakersWire>& makers_wires() {
  static const std::vector<MakersWire> all = [] {
    std::vector<MakersWire> wires;
    for (const std::string& preset : files::preset_names()) {
      wires.push_back(makers_wire(preset));
    }
    return wires;
  }();
  return all;
}

}  // namespace smaservo::choose
