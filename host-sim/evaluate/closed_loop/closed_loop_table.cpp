#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <set>

#include "firmware/safety/faults/table.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/evaluate/closed_loop/closed_loop.hpp"

namespace smaservo {
namespace {

struct RowText {
  std::string_view name, meaning;
  double target_percent;  ///< of the steady error's mean
};

RowText text_of(LoopRow row) {
  switch (row) {
    case LoopRow::weights:
      return {"weights", "100 to 300 MPa", 0.8};
    case LoopRow::spring:
      return {"spring", "from 100..140 to 220..300 MPa", 0.8};
    case LoopRow::light:
      break;
  }
  return {"light", "50 MPa", 2};
}

std::string seconds(double value) {
  return std::isfinite(value) ? fmt::format("{:.3f}", value) : "never";
}

double share(int part, std::size_t whole) {
  return 100.0 * part / static_cast<double>(std::max<std::size_t>(whole, 1));
}

std::string marked(const std::string& text, bool misses) {
  return misses ? "**" + text + "**" : text;
}

/// "0", or how many and for what.
std::string trips(const LoopFigures& f) {
  std::string text = fmt::format("{}", f.trips.size());
  for (const Fault fault : std::set<Fault>(f.trips.begin(), f.trips.end())) {
    text += fmt::format(" {}", fault_name(fault));
  }
  return text;
}

std::string line(const RowText& row, LoopKind kind, const LoopFigures& f) {
  // The targets are the firmware's.
  const bool ours = kind == LoopKind::device;
  const double heated = share(f.heated_in_time, f.heating_s.size());
  const double cooled = share(f.cooled_in_time, f.cooling_s.size());
  return fmt::format(
      "| {} | {} | {} | {:.2f} | {} | {} | {} | {} | {} | {} | {:.0f} |\n", row.name,
      loop_kind_name(kind),
      marked(fmt::format("{:.2f}", f.error.mean()),
             ours && !(f.error.mean() <= row.target_percent)),
      f.error.quantile(0.95), marked(fmt::format("{:.0f} %", heated), ours && heated < 95),
      seconds(f.quantile_s(true, 0.5)),
      marked(fmt::format("{:.0f} %", cooled), ours && cooled < 95),
      seconds(f.quantile_s(false, 0.5)), marked(fmt::format("{}", f.cycles), ours && f.cycles > 0),
      marked(trips(f), ours && !f.trips.empty()), f.above_limit_K);
}

}  // namespace

std::string closed_loop_markdown(const ClosedLoopEvaluation& e) {
  std::string text = fmt::format(
      "Steps between random strains, held for {:g} s, of units {} to {} of each family; errors in "
      "% of the nominal stroke ({:g} % strain) over the last half second. Settled: within ±{:g} %. "
      "Bold: misses its target.\n\n"
      "| load | loop | error | 95 % | heated in 0.10 s | median s | cooled in 1.3 x ideal | median "
      "s | limit cycles | trips | hottest above limit, K |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      loop_hold_s, e.seed, e.seed + static_cast<std::uint64_t>(e.units) - 1, 100 * e.stroke,
      loop_band_percent);
  for (const LoopRowResult& row : e.rows) {
    for (std::size_t i = 0; i < loop_kinds.size(); ++i) {
      text += line(text_of(row.row), loop_kinds.at(i), row.kinds.at(i));
    }
  }
  text +=
      "\nWeights: 100 to 300 MPa, spring: from 100..140 to 220..300 MPa, light: 50 MPa. Targets: "
      "error 0.8, light 2; 95 % in time; no limit cycle. Trips: runs at whose end it had "
      "switched off.\n\n"
      "| -3 dB at ±10 % of the stroke, 200 MPa | lowest unit | highest | target |\n"
      "|---|--:|--:|--:|\n";
  for (std::size_t i = 0; i < loop_kinds.size(); ++i) {
    const auto [least, greatest] = std::ranges::minmax(e.bandwidth_Hz.at(i));
    const bool ours = loop_kinds.at(i) == LoopKind::device;
    text += fmt::format("| {} | {} | {:.2f} Hz | {} |\n", loop_kind_name(loop_kinds.at(i)),
                        marked(fmt::format("{:.2f} Hz", least), ours && least < 2.5), greatest,
                        ours ? "2.5 Hz" : "");
  }
  return e.hottest.empty() ? text : text + "\n" + hottest_markdown(e.hottest);
}

std::string closed_loop_json(const ClosedLoopEvaluation& e) {
  nlohmann::ordered_json json{{"units", e.units}, {"seed", e.seed}, {"stroke", e.stroke}};
  for (const LoopRowResult& row : e.rows) {
    for (std::size_t i = 0; i < loop_kinds.size(); ++i) {
      const LoopFigures& f = row.kinds.at(i);
      const auto finite = [](double value) {
        return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
      };
      json["rows"].push_back(
          {{"load", text_of(row.row).name},
           {"loop", loop_kind_name(loop_kinds.at(i))},
           {"steps", f.heating_s.size() + f.cooling_s.size()},
           {"error_mean_percent", f.error.mean()},
           {"error_p95_percent", f.error.quantile(0.95)},
           {"heated_in_time_percent", share(f.heated_in_time, f.heating_s.size())},
           {"heating_median_s", finite(f.quantile_s(true, 0.5))},
           {"heating_p95_s", finite(f.quantile_s(true, 0.95))},
           {"cooled_in_time_percent", share(f.cooled_in_time, f.cooling_s.size())},
           {"cooling_median_s", finite(f.quantile_s(false, 0.5))},
           {"cooling_p95_s", finite(f.quantile_s(false, 0.95))},
           {"limit_cycles", f.cycles},
           {"trips", f.trips.size()},
           {"above_limit_K", f.above_limit_K}});
    }
  }
  for (std::size_t i = 0; i < loop_kinds.size(); ++i) {
    json["bandwidth_Hz"][std::string(loop_kind_name(loop_kinds.at(i)))] = e.bandwidth_Hz.at(i);
  }
  for (const HottestRun& run : e.hottest) {
    json["random"].push_back({{"seed", run.seed},
                              {"mode", mode_name(run.mode)},
                              {"air", random_air_name(run.air)},
                              {"trouble", random_trouble_name(run.trouble)},
                              {"beyond", run.beyond},
                              {"above_limit_K", run.above_limit_K},
                              {"at_s", run.at_s},
                              {"first_cause", fault_name(run.first_cause)}});
  }
  return json.dump(2) + "\n";
}

}  // namespace smaservo
