#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "firmware/safety/faults/table.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/evaluate/closed_loop/closed_loop.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::evaluate {
namespace {

struct RowText {
  std::string_view name, meaning;
  double target_percent;  ///< target for the mean of the steady error
};

RowText text_of(LoopRow row) {
  switch (row) {
    case LoopRow::weights:
      return {"weights", "100 to 300 MPa", 0.5};
    case LoopRow::spring:
      return {"spring", "from 100..140 to 220..300 MPa", 0.5};
    case LoopRow::light:
      break;
  }
  return {"light", "50 MPa", 0.9};
}

/// An infinite time, which means never, becomes NaN: an empty field.
double finite(double value) {
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

double share(int part, std::size_t whole) {
  return 100.0 * part / static_cast<double>(std::max<std::size_t>(whole, 1));
}

/// The number of trips, and their faults.
std::string trips(const LoopFigures& f) {
  std::string text = fmt::format("{}", f.trips.size());
  for (const Fault fault : std::set<Fault>(f.trips.begin(), f.trips.end())) {
    text += fmt::format(" {}", fault_name(fault));
  }
  return text;
}

/// A line of the table. Marked values miss their target; only the firmware has targets.
files::TextTable::Row line(const RowText& row, LoopKind kind, std::string_view family,
                           const LoopFigures& f) {
  const bool ours = kind == LoopKind::device;
  const double heated = share(f.heated_in_time, f.heating_s.size());
  const double cooled = share(f.cooled_in_time, f.cooling_s.size());
  return {row.name,
          loop_kind_name(kind),
          family,
          f.heating_s.size() + f.cooling_s.size(),
          {f.error.mean(), ours && !(f.error.mean() <= row.target_percent)},
          f.error.quantile(0.95),
          {heated, ours && heated < 95},
          finite(f.quantile_s(true, 0.5)),
          finite(f.quantile_s(true, 0.95)),
          {cooled, ours && cooled < 95},
          finite(f.quantile_s(false, 0.5)),
          finite(f.quantile_s(false, 0.95)),
          {f.cycles, ours && f.cycles > 0},
          {trips(f), ours && !f.trips.empty()},
          f.trips.size(),
          f.above_limit_K};
}

/// Every loop with all wires, and the device with those of each family.
files::TextTable steps(const ClosedLoopEvaluation& e) {
  files::TextTable table({{"load", "", "load"},
                          {"loop", "", "loop"},
                          {"family", "", "family"},
                          {.key = "steps"},
                          {"error", "{:.2f}", "error_mean_percent"},
                          {"95 %", "{:.2f}", "error_p95_percent"},
                          {"heated in 0.10 s", "{:.0f} %", "heated_in_time_percent"},
                          {"median s", "{:.3f}", "heating_median_s"},
                          {.key = "heating_p95_s"},
                          {"cooled in 1.3 x ideal", "{:.0f} %", "cooled_in_time_percent"},
                          {"median s", "{:.3f}", "cooling_median_s"},
                          {.key = "cooling_p95_s"},
                          {"limit cycles", "{}", "limit_cycles"},
                          {"trips", "{}"},
                          {.key = "trips"},
                          {"hottest above limit, K", "{:.0f}", "above_limit_K"}},
                         "never");
  for (const LoopRowResult& result : e.rows) {
    const RowText row = text_of(result.row);
    for (std::size_t i = 0; i < loop_kinds.size(); ++i) {
      table.add(line(row, loop_kinds.at(i), "all", result.kinds.at(i)));
      if (loop_kinds.at(i) != LoopKind::device) {
        continue;
      }
      for (std::size_t k = 0; k < hal::tuning_families.size(); ++k) {
        const LoopFigures& own = result.device_by_family.at(k);
        if (!own.heating_s.empty() || !own.cooling_s.empty()) {
          table.add(line(row, LoopKind::device, hal::family_name(hal::tuning_families.at(k)), own));
        }
      }
    }
  }
  return table;
}

files::TextTable bandwidths(const ClosedLoopEvaluation& e) {
  files::TextTable table({{"-3 dB at ±10 % of the stroke, 200 MPa"},
                          {"lowest unit", "{:.2f} Hz"},
                          {"highest", "{:.2f} Hz"},
                          {"target", "{}"}});
  for (std::size_t i = 0; i < loop_kinds.size(); ++i) {
    const auto [min, max] = std::ranges::minmax(e.bandwidth_Hz.at(i));
    const bool ours = loop_kinds.at(i) == LoopKind::device;
    table.add(
        {loop_kind_name(loop_kinds.at(i)), {min, ours && min < 2.5}, max, ours ? "2.5 Hz" : ""});
  }
  return table;
}

}  // namespace

std::string closed_loop_markdown(const ClosedLoopEvaluation& e) {
  if (e.rows.empty()) {
    return e.hottest.empty() ? "" : hottest_markdown(e.hottest);
  }
  const std::string text = fmt::format(
      "Steps between random strains, held for {:g} s, of units {} to {} of each family; errors in "
      "% of the nominal stroke ({:g} % strain) over the last half second. Settled: within ±{:g} %. "
      "Bold: misses its target.\n\n{}\n"
      "Weights: 100 to 300 MPa, spring: from 100..140 to 220..300 MPa, light: 50 MPa. Targets: "
      "error {:g}, light {:g}; 95 % in time; no limit cycle. Trips: runs at whose end it had "
      "switched off.\n\n{}",
      loop_hold_s, e.seed, e.seed + static_cast<std::uint64_t>(e.units) - 1, 100 * e.stroke,
      loop_band_percent, steps(e).markdown(), text_of(LoopRow::weights).target_percent,
      text_of(LoopRow::light).target_percent, bandwidths(e).markdown());
  return e.hottest.empty() ? text : text + "\n" + hottest_markdown(e.hottest);
}

std::string closed_loop_json(const ClosedLoopEvaluation& e) {
  nlohmann::ordered_json json{{"units", e.units}, {"seed", e.seed}, {"stroke", e.stroke}};
  json["rows"] = steps(e).json();
  for (std::size_t i = 0; i < loop_kinds.size() && !e.rows.empty(); ++i) {
    json["bandwidth_Hz"][std::string(loop_kind_name(loop_kinds.at(i)))] = e.bandwidth_Hz.at(i);
  }
  for (const HottestRun& run : e.hottest) {
    json["random"].push_back({{"seed", run.seed},
                              {"mode", text::mode_name(run.mode)},
                              {"air", random_air_name(run.air)},
                              {"trouble", random_trouble_name(run.trouble)},
                              {"beyond", run.beyond},
                              {"duration_s", run.duration_s},
                              {"above_limit_K", run.above_limit_K},
                              {"at_s", run.at_s},
                              {"over_s", run.over_s},
                              {"unanswered", run.unanswered},
                              {"cooling_halved", run.halved},
                              {"first_cause", fault_name(run.first_cause)}});
  }
  return files::json_text(json);
}

}  // namespace smaservo::evaluate
