#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host-sim/checks/findings.hpp"
#include "host-sim/checks/statistics.hpp"

namespace smaservo::checks {
namespace {

/// The mean resistance of the coldest and of the hottest tenth of the rows that have one.
struct Ends {
  double cold_ohm = 0, hot_ohm = 0, warming_K = 0, change = 0;
};

Ends ends_of(const Record& record, const Values& heating_K) {
  std::vector<std::pair<double, double>> rows;
  for (std::size_t i = 0; i < heating_K.size() && i < record.resistance_ohm.size(); ++i) {
    if (!std::isnan(record.resistance_ohm[i])) {
      rows.emplace_back(heating_K[i], record.resistance_ohm[i]);
    }
  }
  Ends ends;
  if (rows.size() < 20) {
    return ends;
  }
  std::ranges::sort(rows);
  const std::size_t tenth = rows.size() / 10;
  Values cold, hot, all;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    all.push_back(rows[i].second);
    if (i < tenth) {
      cold.push_back(rows[i].second);
    }
    if (i + tenth >= rows.size()) {
      hot.push_back(rows[i].second);
    }
  }
  const Range range = range_of(all);
  ends.cold_ohm = range_of(cold).middle;
  ends.hot_ohm = range_of(hot).middle;
  ends.warming_K = rows[rows.size() - 1 - tenth / 2].first - rows[tenth / 2].first;
  ends.change = (range.high - range.low) / range.middle;
  return ends;
}

}  // namespace

void check_alloy(const Record& record, const RecordedWire& wire, Findings& found) {
  constexpr double no_heat_K = 10;
  constexpr double surely_transformed_K = 150;  ///< in still air; no wire is cooled so much better
  constexpr double least_change = 0.01;
  constexpr double most_rise = 0.2;
  if (record.kind != RunKind::joule || record.current_A.size() != record.voltage_V.size()) {
    return;
  }
  const Values heating = heating_K(record, wire.geometry);
  const double most_K = heating.empty() ? 0 : *std::ranges::max_element(heating);
  if (most_K < no_heat_K) {
    found.push_back(
        {"heat", false,
         fmt::format("the wire is never heated: the power warms it by {:.2g} K at most, and a wire "
                     "transforms 30 to 80 K above the air, so an estimate shows a wire at rest. If "
                     "it was heated, check the units of current and voltage, and the length",
                     std::max(most_K, 0.0))});
    return;
  }
  const Ends ends = ends_of(record, heating);
  const bool transformed = ends.warming_K > surely_transformed_K;
  if (ends.warming_K > 40 && ends.hot_ohm > (1 + most_rise) * ends.cold_ohm) {
    found.push_back(
        {"alloy", true,
         fmt::format("the resistance rises from {:.4g} to {:.4g} ohm where the wire is heated, as "
                     "that of copper, steel or tungsten; the resistance of NiTi falls by 5 to 20 % "
                     "when it transforms. Check that it is a shape-memory wire, and that the "
                     "voltage was measured at its ends by two wires of their own",
                     ends.cold_ohm, ends.hot_ohm)});
  } else if (transformed && ends.change < least_change) {
    found.push_back(
        {"alloy", true,
         fmt::format("the resistance changes by {:.1g} % while the power would warm the wire by "
                     "{:.0f} K in still air; the resistance of NiTi falls by 5 to 20 % when it "
                     "transforms. Check that it is a shape-memory wire (nichrome and constantan "
                     "stay the same), and its length and diameter",
                     100 * ends.change, ends.warming_K)});
  }
}

}  // namespace smaservo::checks
