#include "host-sim/commission/output.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <nlohmann/json.hpp>

#include "host-sim/identify/fitted_wire.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::commission {
namespace {

std::string readings(std::size_t count) {
  return count == 0 ? "no reading" : count == 1 ? "1 reading" : fmt::format("{} readings", count);
}

std::string short_name(const identify::FittedParameter& fitted) {
  return fitted.parameter.key.substr(identify::group_of(fitted.parameter.key).size() + 1);
}

/// The learned, or the other, parameters as lines "wire.martensite: strain from ... to ...".
std::string parameter_lines(const Commissioned& found, bool learned) {
  std::string lines;
  for (const identify::FittedParameter& fitted : found.parameters) {
    if (fitted.determined == learned) {
      lines += fmt::format("  {} {}\n", identify::group_of(fitted.parameter.key),
                           identify::moved_text(fitted, short_name(fitted)));
    }
  }
  return lines;
}

std::string beginning_text(const Commissioned& found) {
  if (std::isnan(found.ahead)) {
    return "transformations: the type's; the readings cannot decide between kinds of wires\n";
  }
  const char* sure = found.ahead < 1 ? "hardly" : found.ahead < 3 ? "somewhat" : "clearly";
  return fmt::format("transformations: {}, which fit the run {} better than {}\n",
                     found.broad ? "broad ones" : "the type's", sure,
                     found.broad ? "the type's" : "broad ones");
}

files::TextTable error_table(const Commissioned& found) {
  files::TextTable table(
      {{"expected mean error, % of the stroke"}, {"before", "{:.1f}"}, {"after", "{:.1f}"}});
  table.add({"length of the wire (strain)", 100 * found.before.strain, 100 * found.after.strain});
  table.add(
      {"stroke since the run's beginning", 100 * found.before.stroke, 100 * found.after.stroke});
  return table;
}

files::TextTable anchor_table(const Commissioned& found) {
  files::TextTable table({{"reading at s", "{:.2f}", "time_s"},
                          {"mm", "{:.3f}", "displacement_m", 1e3},
                          {"sd", "{:.2g}", "sd_m", 1e3},
                          {"observer before", "{:.3f}", "before_m", 1e3},
                          {"after", "{:.3f}", "after_m", 1e3}});
  for (const AnchorFit& fit : found.anchors) {
    table.add(
        {fit.anchor.time_s, fit.anchor.displacement_m, fit.anchor.sd_m, fit.before_m, fit.after_m});
  }
  return table;
}

/// What would tell more.
std::string advice(const Commissioning& all) {
  if (std::isnan(all.found.ahead)) {
    return "no readings of the displacement that are half a stroke apart: so the run tells\n"
           "little of the stroke. One of the cold and one of the hot wire would\n";
  }
  if (all.zero == Zero::common) {
    return "the wire's length stays less well known than its stroke. Where wire.length is\n"
           "known within 0.1 mm, --zero length tells more\n";
  }
  return "";
}

}  // namespace

files::WireDescription commissioned_wire(const Commissioning& all, const std::string& name) {
  const std::string source =
      fmt::format("{} and {}", identify::file_name(all.run), readings(all.found.anchors.size()));
  std::map<std::string, std::string> sources(all.from.sources.begin(), all.from.sources.end());
  sources.erase("wire.resistance");
  sources.erase("wire.resistance_ohm");
  std::map<std::string, std::vector<std::string>> learned;
  for (const identify::FittedParameter& fitted : all.found.parameters) {
    learned[identify::group_of(fitted.parameter.key)].push_back(
        identify::moved_text(fitted, short_name(fitted)));
  }
  for (const auto& [group, texts] : learned) {
    sources[group] = fmt::format(
        "commissioned with {}: {}; its resistivities are scaled to {:.4g} ohm, measured cold; the "
        "rest is {}",
        source, fmt::join(texts, ", "), all.found.cold_ohm,
        all.found.broad ? fmt::format("{} with broad transformations", all.from.name)
                        : all.from.name);
  }
  if (all.found.broad) {
    for (const char* group : {"wire.m2a", "wire.a2m", "wire.a2r", "wire.r2a", "wire.heat"}) {
      std::erase_if(sources, [&](const auto& one) {
        return one.first == group || one.first.starts_with(std::string(group) + ".");
      });
      sources[group] = fmt::format(
          "{} with broad transformations, which explain {} better (host-sim/commission/README.md)",
          all.from.name, source);
    }
  }
  sources["wire.accuracy.strain"] =
      fmt::format("expected of a wire commissioned with {}", readings(all.found.anchors.size()));
  files::WireDescription wire{name, all.found.wire, {sources.begin(), sources.end()}};
  try {
    files::parse_wire(files::to_toml(wire), wire.name);
  } catch (const files::ConfigError& error) {
    throw files::UserError(
        fmt::format("{} leads to an impossible wire: {}", all.run, error.what()));
  }
  return wire;
}

std::string text(const Commissioning& all) {
  const Commissioned& found = all.found;
  std::string out =
      fmt::format("{}\n  from {}, {} and {}, in {:.1f} s\n", files::printable(all.out),
                  files::printable(all.from.name), identify::file_name(all.run),
                  readings(found.anchors.size()), all.elapsed_s);
  out += fmt::format("cold resistance: {:.4g} ohm, {:+.1f} % of the type's\n", found.cold_ohm,
                     100 * (found.cold_factor - 1));
  out += beginning_text(found);
  if (!found.anchors.empty()) {
    out += fmt::format("readings and parameters are {:.1f} standard deviations from the type\n",
                       found.distance);
  }
  out += fmt::format("resistance explained within {:.2f} % (RMS), before {:.2f} %\n\n",
                     100 * found.innovation_after, 100 * found.innovation_before);
  out += error_table(found).text() + "\n";
  if (!found.anchors.empty()) {
    out += anchor_table(found).text() + "\n";
  }
  const std::string learned = parameter_lines(found, true);
  const std::string others = parameter_lines(found, false);
  out += learned.empty() ? "" : "learned:\n" + learned;
  out += others.empty() ? "" : "not learned, and near the type's:\n" + others;
  return out + advice(all);
}

std::string json(const Commissioning& all) {
  const Commissioned& found = all.found;
  nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
  for (const identify::FittedParameter& fitted : found.parameters) {
    const identify::Figure f = identify::figure(fitted);
    parameters.push_back({{"key", fitted.parameter.key},
                          {"unit", fitted.parameter.unit},
                          {"prior", f.prior},
                          {"prior_sd", f.prior_sd},
                          {"value", f.value},
                          {"sd", f.sd},
                          {"learned", fitted.determined}});
  }
  const nlohmann::ordered_json document{
      {"out", all.out},
      {"from", all.from.name},
      {"run", all.run},
      {"zero", all.zero == Zero::length ? "length" : "common"},
      {"broad", found.broad},
      {"ahead",
       std::isnan(found.ahead) ? nlohmann::ordered_json() : nlohmann::ordered_json(found.ahead)},
      {"distance", found.distance},
      {"cold_ohm", found.cold_ohm},
      {"cold_factor", found.cold_factor},
      {"expected_error_of_stroke",
       {{"before", {{"strain", found.before.strain}, {"stroke", found.before.stroke}}},
        {"after", {{"strain", found.after.strain}, {"stroke", found.after.stroke}}}}},
      {"resistance_rms", {{"before", found.innovation_before}, {"after", found.innovation_after}}},
      {"anchors", anchor_table(found).json()},
      {"parameters", parameters},
      {"elapsed_s", all.elapsed_s}};
  return files::json_text(document);
}

std::vector<report::Panel> panels(const Commissioning& all) {
  const Commissioned& found = all.found;
  const auto percent = [](const std::vector<double>& values) {
    return report::column_of(values, [](double v) { return 100 * v; });
  };
  const report::Column time = report::column(found.trace_after.time_s);
  std::vector<double> low, high;
  for (std::size_t i = 0; i < found.trace_after.strain.size(); ++i) {
    low.push_back(100 * (found.trace_after.strain[i] - 2 * found.trace_after.strain_sd[i]));
    high.push_back(100 * (found.trace_after.strain[i] + 2 * found.trace_after.strain_sd[i]));
  }
  report::Panel strain{.title = "Strain",
                       .caption =
                           "the observer with the commissioned wire, two reported standard "
                           "deviations around it, and with the type",
                       .height = 340,
                       .x = {.label = "time in s"},
                       .y = {.label = "strain in %"},
                       .link = "run"};
  strain.series.push_back({.name = "within 2 sd",
                           .colour = "band",
                           .kind = report::Kind::band,
                           .x = time,
                           .y = report::column(high),
                           .low = report::column(low)});
  strain.series.push_back({.name = "commissioned",
                           .colour = "estimate",
                           .x = time,
                           .y = percent(found.trace_after.strain)});
  strain.series.push_back({.name = "type",
                           .colour = "planned",
                           .x = report::column(found.trace_before.time_s),
                           .y = percent(found.trace_before.strain),
                           .dashed = true});
  if (!found.anchors.empty()) {
    // A reading is drawn where it is with the zero that the fit has found.
    std::vector<double> at_s, read;
    const double length_m = all.from.wire.geometry.length_m;
    const auto strain_at = [&](double at) {
      const std::vector<double>& times = found.trace_after.time_s;
      const auto next = std::ranges::lower_bound(times, at);
      const auto i =
          std::min<std::size_t>(static_cast<std::size_t>(next - times.begin()), times.size() - 1);
      return found.trace_after.strain[i];
    };
    for (const AnchorFit& fit : found.anchors) {
      at_s.push_back(fit.anchor.time_s);
      read.push_back(100 * (strain_at(fit.anchor.time_s) +
                            (fit.after_m - fit.anchor.displacement_m) / length_m));
    }
    strain.series.push_back({.name = "readings",
                             .colour = "reference",
                             .kind = report::Kind::points,
                             .x = report::column(at_s),
                             .y = report::column(read),
                             .width = 3});
  }
  report::Panel resistance{.title = "Resistance",
                           .caption = "measured, and as the observer expects it before it corrects",
                           .height = 260,
                           .x = {.label = "time in s"},
                           .y = {.label = "resistance in ohm"},
                           .link = "run"};
  resistance.series.push_back({.name = "measured",
                               .colour = "measured",
                               .x = time,
                               .y = report::column(found.trace_after.resistance_ohm)});
  resistance.series.push_back({.name = "expected",
                               .colour = "estimate",
                               .x = time,
                               .y = report::column(found.trace_after.resistance_model_ohm)});
  return {strain, resistance};
}

}  // namespace smaservo::commission
