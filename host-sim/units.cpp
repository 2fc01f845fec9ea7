#include "host-sim/units.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace smaservo {
namespace {

constexpr std::array<std::string_view, 7> bench_suffixes{"degC", "MPa",  "mA",     "mW",
                                                         "um",   "mm_s", "percent"};

}  // namespace

Unit unit_in(Kind kind, Units units) {
  const auto found = std::ranges::find_if(kind, [](const Unit& unit) {
    return std::ranges::find(bench_suffixes, unit.suffix) != bench_suffixes.end();
  });
  return units == Units::bench && found != kind.end() ? *found : kind.front();
}

}  // namespace smaservo
