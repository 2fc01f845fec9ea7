#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <utility>

#include "host-sim/inspect/inspect.hpp"
#include "host-sim/report/html.hpp"
#include "host-sim/report/thin.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"
#include "model/files/wrapped.hpp"

namespace smaservo::inspect {
namespace {

std::string shortened(const std::string& name) {
  constexpr std::size_t longest = 30;
  return files::printable(name.size() > longest ? name.substr(0, longest) + "..." : name);
}

files::TextTable columns_of(const Facts& facts) {
  files::TextTable table({{"no.", "{}", "column"},
                          {.heading = "name", .key = "name"},
                          {.heading = "taken as", .key = "meaning"},
                          {"from", "{:.5g}", "low"},
                          {"to", "{:.5g}", "high"},
                          {"step", "{:.2g}", "step"},
                          {.heading = "unit", .key = "unit"}},
                         "");
  for (std::size_t i = 0; i < facts.columns.size(); ++i) {
    const ColumnFacts& c = facts.columns[i];
    const std::string name = shortened(c.name);
    if (!c.is_number) {
      table.add({i + 1, name, "text"});
    } else {
      table.add({i + 1, name, c.meaning.empty() ? "-" : c.meaning, c.low, c.high,
                 std::isfinite(c.step) ? files::TextTable::Cell(c.step) : files::TextTable::Cell(),
                 c.unit});
    }
  }
  return table;
}

/// "100 rows/s (jitter 0.3 ms), longest step 35 ms before line 1200, 2 gaps".
std::string rate_of(const Facts& facts) {
  if (!facts.timed || !(facts.step_s > 0)) {
    return facts.timed ? "one row" : "no time; --period-s gives the time between rows";
  }
  // Times as 0.004 are not exact in binary.
  const double jitter_s = facts.jitter_s > 1e-6 * facts.step_s ? facts.jitter_s : 0;
  return fmt::format("{:.4g} rows/s (jitter {:.2g} ms), longest step {} before {}, {}",
                     1 / facts.step_s, 1e3 * jitter_s,
                     facts.longest_s < 1 ? fmt::format("{:.3g} ms", 1e3 * facts.longest_s)
                                         : fmt::format("{:.4g} s", facts.longest_s),
                     facts.longest_at,
                     facts.gaps == 0   ? "no gaps"
                     : facts.gaps == 1 ? "1 gap"
                                       : fmt::format("{} gaps", facts.gaps));
}

/// Which wires have the resistance, as NiTi of 0.9 uohm m.
std::string resistance_of(const Facts& facts, const InspectOptions& options) {
  if (facts.resistances == 0) {
    return "none: no row has current and voltage";
  }
  const double middle_ohm = (facts.ohm_low + facts.ohm_high) / 2;
  const std::string text = fmt::format("{:.4g} to {:.4g} ohm in {} of {} rows", facts.ohm_low,
                                       facts.ohm_high, facts.resistances, facts.rows);
  const Geometry<double>& g = options.wire.wire.geometry;
  if (options.wire_given) {
    return text + fmt::format("; {:.3g} uohm_m for {:.4g} mm of {:.4g} um",
                              1e6 * middle_ohm * g.area_m2() / g.length_m, 1e3 * g.length_m,
                              1e6 * g.diameter_m);
  }
  constexpr double usual_ohm_m = 0.9e-6;
  std::vector<std::string> wires;
  wires.reserve(3);
  for (const double diameter_m : {76e-6, 150e-6, 300e-6}) {
    const double area_m2 = Geometry<double>{1, diameter_m}.area_m2();
    wires.push_back(fmt::format("{:.3g} mm of {:.0f} um", 1e3 * middle_ohm * area_m2 / usual_ohm_m,
                                1e6 * diameter_m));
  }
  return text + fmt::format("; as {}", fmt::join(wires, ", "));
}

std::string heatings_of(const Facts& facts, const InspectOptions& options) {
  std::string text = fmt::format("{}", facts.heatings);
  if (options.wire_given && !facts.loads_MPa.empty()) {
    text += fmt::format(", under {} load{}: {:.3g} MPa", facts.loads_MPa.size(),
                        facts.loads_MPa.size() == 1 ? "" : "s", fmt::join(facts.loads_MPa, ", "));
  }
  return text;
}

/// A text after a heading.
std::string paragraph(std::string_view heading, std::string_view text) {
  return files::paragraph(heading, text, 12);
}

std::string wire_hint() {
  return "none is given, so only directions, clipping and sampling are checked; name it by --wire "
         "NAME (host-sim wires lists them) or --set wire.length_mm=L";
}

report::Panel panel(const char* title, const char* label, int height) {
  report::Panel made;
  made.title = title;
  made.y.label = label;
  made.x.label = "time in s";
  made.height = height;
  made.link = "time";
  return made;
}

/// What the report draws of one quantity.
struct Drawn {
  const char* title;
  const char* label;
  const std::vector<double>& values;
  double factor;
};

std::vector<report::Panel> panels_of(const Facts& facts) {
  const checks::Record& r = facts.record;
  const Drawn all[] = {{"Current", "current in mA", r.current_A, 1e3},
                       {"Voltage", "voltage in V", r.voltage_V, 1},
                       {"Resistance", "resistance in \u03A9", r.resistance_ohm, 1},
                       {"Stress", "stress in MPa", r.stress_Pa, 1e-6},
                       {"Strain", "strain in %", r.strain, 100},
                       {"Temperature", "temperature in K", r.temperature_K, 1}};
  std::vector<const std::vector<double>*> columns;
  for (const Drawn& drawn : all) {
    if (!drawn.values.empty()) {
      columns.push_back(&drawn.values);
    }
  }
  constexpr std::size_t most_points = 4000;
  const std::vector<std::size_t> rows = report::rows_to_show(columns, most_points);
  const report::Column time = report::column_of(rows, [&](std::size_t i) {
    return r.time_s.empty() ? static_cast<double>(i) : r.time_s[i] - r.time_s.front();
  });
  std::vector<report::Panel> panels;
  for (const Drawn& drawn : all) {
    if (drawn.values.empty()) {
      continue;
    }
    report::Panel made = panel(drawn.title, drawn.label, 200);
    made.x.label = r.time_s.empty() ? "row" : made.x.label;
    made.series.push_back({.name = "measured",
                           .colour = "ink",
                           .x = time,
                           .y = report::column_of(rows, [&](std::size_t i) {
                             return drawn.factor * drawn.values[i];
                           })});
    panels.push_back(std::move(made));
  }
  return panels;
}

}  // namespace

std::string text_of(const Facts& facts, const InspectOptions& options) {
  std::string text = fmt::format("{}: {} rows{}\n", files::printable(facts.name), facts.rows,
                                 facts.timed ? fmt::format(", {:.4g} s", facts.duration_s) : "");
  if (!facts.read_as.empty()) {
    text += paragraph("read as", files::printable(facts.read_as));
  }
  text += columns_of(facts).text();
  text += paragraph("rate", rate_of(facts));
  text += paragraph("resistance", resistance_of(facts, options));
  text += paragraph("heatings", heatings_of(facts, options));
  if (!options.wire_given) {
    text += paragraph("wire", wire_hint());
  }
  for (const std::string& hint : facts.hints) {
    text += paragraph("unclear", files::printable(hint));
  }
  for (const std::string& skipped : facts.skipped) {
    text += paragraph("skipped", files::printable(skipped));
  }
  for (const checks::Finding& finding : facts.findings) {
    text += paragraph(finding.is_error ? "mistake" : "note", files::printable(finding.text));
  }
  for (const Use& use : facts.uses) {
    text += use.command.empty()
                ? paragraph(use.name, use.why)
                : fmt::format("{:<12}{}\n{}", use.name, files::printable(use.command),
                              use.why.empty() ? "" : paragraph("", use.why));
  }
  return text;
}

std::string json_of(const std::vector<Facts>& all) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Facts& f : all) {
    nlohmann::ordered_json file{{"trace", f.name},
                                {"read_as", f.read_as},
                                {"rows", f.rows},
                                {"bad_rows", f.bad_rows},
                                {"duration_s", f.duration_s},
                                {"step_s", f.step_s},
                                {"jitter_s", f.jitter_s},
                                {"longest_step_s", f.longest_s},
                                {"gaps", f.gaps},
                                {"columns", columns_of(f).json()},
                                {"rows_with_resistance", f.resistances},
                                {"resistance_low_ohm", f.ohm_low},
                                {"resistance_high_ohm", f.ohm_high},
                                {"heatings", f.heatings},
                                {"loads_MPa", f.loads_MPa},
                                {"unclear", f.hints},
                                {"skipped", f.skipped}};
    file["findings"] = nlohmann::ordered_json::array();
    for (const checks::Finding& finding : f.findings) {
      file["findings"].push_back(
          {{"check", finding.check}, {"mistake", finding.is_error}, {"text", finding.text}});
    }
    for (const Use& use : f.uses) {
      file["uses"][use.name] = {{"command", use.command}, {"why", use.why}};
    }
    json.push_back(std::move(file));
  }
  return files::json_text(json);
}

void write_report(const std::string& path, const Facts& facts, const InspectOptions& options,
                  Units units) {
  std::string html = columns_of(facts).html();
  const auto line = [&](std::string_view heading, const std::string& text) {
    html += fmt::format("<p><b>{}</b> {}</p>\n", heading, files::escaped(text));
  };
  if (!facts.read_as.empty()) {
    line("Read as", facts.read_as);
  }
  line("Rate", rate_of(facts));
  line("Resistance", resistance_of(facts, options));
  line("Heatings", heatings_of(facts, options));
  for (const checks::Finding& finding : facts.findings) {
    line(finding.is_error ? "Mistake" : "Note", finding.text);
  }
  for (const std::string& hint : facts.hints) {
    line("Unclear", hint);
  }
  for (const std::string& skipped : facts.skipped) {
    line("Skipped", skipped);
  }
  html += report::plots_html(panels_of(facts), units);
  std::string commands;
  for (const Use& use : facts.uses) {
    commands += fmt::format("{}: {}{}\n", use.name, use.command,
                            use.why.empty() ? "" : (use.command.empty() ? "" : "  # ") + use.why);
  }
  html += report::listing_html("What can be done", commands);
  report::write_html(path, files::printable(facts.name), html);
}

}  // namespace smaservo::inspect
