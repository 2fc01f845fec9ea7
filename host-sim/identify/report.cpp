#include "host-sim/identify/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host-sim/identify/fit_plots.hpp"
#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"
#include "model/files/wrapped.hpp"
#include "model/units.hpp"

namespace smaservo::identify {
namespace {

constexpr std::size_t shown_correlations = 5;
constexpr std::size_t widest_line = 78;  ///< 80 columns less the indent of a list

std::size_t rows_of(const FittedRun& run) {
  return std::max({run.strain.count, run.resistance.count, run.power.count, run.stress_Pa.count});
}

/// One line: files, runs, iterations, time.
std::string heading(const Identification& all) {
  return fmt::format("{} from {} and {} run{}, {} iterations, {:.1f} s{}",
                     files::printable(all.out), files::printable(all.from), all.runs.size(),
                     all.runs.size() == 1 ? "" : "s", all.fit.iterations, all.elapsed_s,
                     all.fit.interrupted  ? ", INTERRUPTED: the best so far, not the end"
                     : !all.fit.converged ? ", NOT CONVERGED: the best so far, not the end"
                                          : "");
}

std::string structure(const FitVariant& v) {
  return fmt::format("{}, {}, {}{}{}, resistivities {}",
                     v.r2a_near_a2r   ? "R2A on a surface of its own, found near A2R"
                     : v.separate_r2a ? "R2A on a surface of its own"
                                      : "R2A as M2A",
                     v.separate_r2m ? "R2M on a surface of its own" : "R2M as A2M",
                     v.memory == Memory::return_point ? "inner loops close at their return points"
                                                      : "inner loops without memory",
                     v.loop_order ? " and have an order" : "",
                     v.taper ? ", ends of the curves fitted" : "",
                     v.mixture == Mixture::series ? "in series" : "in parallel");
}

std::string circuit(const FitResult& fit) {
  if (!fit.circuit_fitted) {
    return "";
  }
  return fmt::format(
      "leads {:.4f} ohm, load cell reads {:.4f} times the load; replay with --set "
      "measurement.lead_resistance_ohm={:.4f} and --column load_N=load_N*{:.4f}\n",
      fit.circuit.lead_ohm, fit.circuit.load_gain, fit.circuit.lead_ohm, 1 / fit.circuit.load_gain);
}

/// Lines for each group that has such parameters: for undetermined ones "wire.m2a: bend, turning";
/// for determined ones the values before and after the fit. A group that does not fit into one line
/// goes on in indented ones. Lines are measured in bytes: one with "±" ends a little earlier.
std::vector<std::string> parameters_text(const FitResult& fit, bool determined) {
  std::vector<std::string> lines;
  std::string open;
  for (const FittedParameter& fitted : fit.parameters) {
    if (fitted.determined != determined) {
      continue;
    }
    const std::string& key = fitted.parameter.key;
    const std::string group = group_of(key);
    const std::string name = key.substr(group.size() + 1);
    const std::string text = determined ? moved_text(fitted, name) : name;
    if (group != open) {
      lines.push_back(group + ": " + text);
      open = group;
    } else if (lines.back().size() + text.size() + 3 <= widest_line) {  // ", " and a comma behind
      lines.back() += ", " + text;
    } else {
      lines.back() += ',';
      lines.push_back("  " + text);
    }
  }
  return lines;
}

/// Whether a run has errors of this kind.
bool has(const std::vector<FittedRun>& runs, FitQuality FittedRun::* quality) {
  return std::ranges::any_of(runs, [&](const FittedRun& run) { return (run.*quality).count > 0; });
}

/// The errors of each run, with columns for strain, resistance and the classic functions if a run
/// has them.
files::TextTable runs_table(const std::vector<FittedRun>& runs,
                            const std::vector<std::vector<double>>& classics,
                            const std::vector<std::string_view>& classic_names) {
  std::vector<files::TextTable::Column> columns{{"run"}, {"kind"}, {"rows", "{}"}};
  const auto add = [&](const std::string& heading) {
    columns.push_back({heading, "{:.2f}", "", 100});
  };
  const bool stresses = has(runs, &FittedRun::stress_Pa);
  if (stresses) {
    for (const char* const heading : {"stress RMS", "stress 95 %", "stress max"}) {
      columns.push_back({heading, "{:.1f}", "", 1e-6});
    }
  }
  const bool strains = has(runs, &FittedRun::strain);
  const bool ohms = has(runs, &FittedRun::resistance);
  if (strains) {
    std::ranges::for_each(std::array{"strain RMS", "strain 95 %", "strain max"}, add);
  }
  if (ohms) {
    std::ranges::for_each(std::array{"resistance RMS", "resistance max"}, add);
  }
  for (const std::string_view name : classic_names) {
    add(fmt::format("{} RMS", name));
  }
  files::TextTable table(std::move(columns), "");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const FittedRun& run = runs[i];
    const auto there = [](const FitQuality& quality, double share) {
      return quality.count > 0 ? share : files::TextTable::Cell{};
    };
    const FitQuality& strain = run.strain;
    const FitQuality& ohm = run.resistance;
    files::TextTable::Row row{file_name(run.name), name_of(run.kind), rows_of(run)};
    if (stresses) {
      const FitQuality& stress = run.stress_Pa;
      row.insert(row.end(), {there(stress, stress.rms), there(stress, stress.p95),
                             there(stress, stress.maximum)});
    }
    if (strains) {
      row.insert(row.end(), {there(strain, strain.rms), there(strain, strain.p95),
                             there(strain, strain.maximum)});
    }
    if (ohms) {
      row.insert(row.end(), {there(ohm, ohm.rms), there(ohm, ohm.maximum)});
    }
    if (i < classics.size()) {
      row.insert(row.end(), classics[i].begin(), classics[i].end());
    }
    table.add(std::move(row));
  }
  return table;
}

files::TextTable runs_table(const Identification& all) {
  std::vector<std::string_view> names;
  for (const ClassicFit& classic :
       std::ranges::max(all.classics, {}, &std::vector<ClassicFit>::size)) {
    names.push_back(classic.name);
  }
  std::vector<std::vector<double>> errors(all.classics.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    for (const ClassicFit& classic : all.classics[i]) {
      errors[i].push_back(classic_rms(classic, all.runs[i], all.fit.wire.nominal_stroke));
    }
  }
  return runs_table(all.fit.runs, errors, names);
}

constexpr std::string_view held_out_heading =
    "runs held out: of each the first third tells its zero, air and heat loss, the\n"
    "rest is predicted:";

constexpr std::string_view judgement_heading =
    "structures by the observer's mean error in % of the stroke:";

/// The observer's mean errors with each structure that was judged.
files::TextTable judgement_table(const FitResult& fit) {
  files::TextTable table({{"structure"},
                          {"in runs of the fit", "{:.2f}", "", 100},
                          {"in runs left out", "{:.2f}", "", 100},
                          {""}});
  const Judgement& judgement = fit.judgement;
  for (const JudgedStructure& judged : judgement.structures) {
    const bool chosen = judged.structure == judgement.chosen();
    table.add({structure_name(judged.structure), mean_error(judged.seen), mean_error(judged.unseen),
               chosen ? "chosen" : "not chosen"});
  }
  return table;
}

/// What a reader has to know of the choice besides the table.
std::string judgement_text(const FitResult& fit) {
  const double stroke = fit.wire.nominal_stroke;
  std::string text;
  if (fit.structure_asked == Structure::automatic && fit.judgement.structures.empty()) {
    text = fmt::format(
        "no structure was chosen: that takes {} runs with current, voltage and strain\n",
        least_judged_runs);
  }
  if (!std::isnan(fit.share_within_2_sd)) {
    text += fmt::format(
        "in runs left out {:.0f} % of the observer's errors are within twice the deviation that "
        "it\n"
        "reports with wire.accuracy.strain of {:.2f} % of the stroke; the fit leaves {:.2f} %\n",
        100 * fit.share_within_2_sd, 100 * fit.wire.accuracy.strain / stroke,
        100 * fit.strain_sd / stroke);
  }
  return text;
}

std::string heat_flows(const FitResult& fit) {
  std::string text;
  for (const FittedRun& run : fit.runs) {
    if (run.kind == RunKind::calorimetry) {
      text += fmt::format("{}: heat flow RMS {:.2f}, 95 % {:.2f}, max {:.2f} % of its greatest\n",
                          file_name(run.name), 100 * run.power.rms, 100 * run.power.p95,
                          100 * run.power.maximum);
    }
  }
  return text;
}

/// How far the fit began from the transitions of --from.
std::string offset_text(const Identification& all) {
  return all.fit.moved_K == 0
             ? ""
             : fmt::format(
                   "the fit begins with all transitions of {}\n  moved by {:.1f} K, to "
                   "where the runs show them\n",
                   files::printable(all.from), all.fit.moved_K);
}

std::string joint_text(const std::vector<FittedRun>& runs) {
  const auto strain = joint_rms(runs, &FittedRun::strain);
  const auto stress_Pa = joint_rms(runs, &FittedRun::stress_Pa);
  return (strain ? fmt::format("strain of these runs: RMS {:.2f} % of the nominal stroke\n",
                               100 * *strain)
                 : "") +
         (stress_Pa ? fmt::format("stress of these runs: RMS {:.1f} MPa\n", 1e-6 * *stress_Pa)
                    : "");
}

std::string correlations_text(const FitResult& fit) {
  std::string text;
  for (std::size_t i = 0; i < std::min(shown_correlations, fit.correlations.size()); ++i) {
    const Correlation& c = fit.correlations[i];
    text += fmt::format("  {:+.3f}  {}, {}\n", c.value, c.first, c.second);
  }
  return text;
}

/// The units of the table of the runs.
std::string unit_of_errors(const Identification& all) {
  const bool classic =
      std::ranges::any_of(all.classics, [](const auto& of) { return !of.empty(); });
  const std::string strain =
      fmt::format("strain{} in % of the {:g} % stroke",
                  classic ? ", also by classic functions," : "", 100 * all.fit.wire.nominal_stroke);
  const bool strains = has(all.fit.runs, &FittedRun::strain);
  const bool ohms = has(all.fit.runs, &FittedRun::resistance);
  std::vector<std::string> units;
  if (has(all.fit.runs, &FittedRun::stress_Pa)) {
    units.emplace_back("stress in MPa");
  }
  if (strains) {
    units.push_back(strain);
  }
  if (ohms) {
    units.emplace_back("resistance in %");
  }
  return fmt::format("{}", fmt::join(units, "; "));
}

std::string parameters_html(const FitResult& fit) {
  files::TextTable table({{"parameter"}, {"before"}, {"fitted"}, {"unit"}, {""}});
  for (const FittedParameter& fitted : fit.parameters) {
    const Figure f = figure(fitted);
    table.add({fitted.parameter.key, with_deviation(f.prior, f.prior_sd),
               with_deviation(f.value, f.sd), fitted.parameter.unit,
               fitted.determined ? "" : "not determined"});
  }
  return "<h2>Parameters</h2>\n" + table.html() +
         "<p class=\"caption\">± one standard deviation. Not determined: the runs tell little of "
         "it, so it is kept as it was.</p>\n";
}

using Json = nlohmann::ordered_json;

Json quality_json(const FitQuality& quality) {
  return {{"rms_percent", 100 * quality.rms},
          {"p95_percent", 100 * quality.p95},
          {"max_percent", 100 * quality.maximum},
          {"rows", quality.count}};
}

Json run_json(const FittedRun& run) {
  Json json{{"file", run.name}, {"kind", name_of(run.kind)}, {"rows", rows_of(run)}};
  const std::pair<const char*, const FitQuality*> qualities[] = {
      {"strain", &run.strain}, {"resistance", &run.resistance}, {"heat_flow", &run.power}};
  for (const auto& [name, quality] : qualities) {
    if (quality->count > 0) {
      json[name] = quality_json(*quality);
    }
  }
  if (run.stress_Pa.count > 0) {
    json["stress"] = {{"rms_MPa", 1e-6 * run.stress_Pa.rms},
                      {"p95_MPa", 1e-6 * run.stress_Pa.p95},
                      {"max_MPa", 1e-6 * run.stress_Pa.maximum},
                      {"rows", run.stress_Pa.count}};
  }
  const Circumstances<double>& c = run.circumstances;
  const bool imposed = run.kind == RunKind::imposed;
  if (run.kind == RunKind::joule || run.kind == RunKind::settled || imposed) {
    json["ambient_degC"] = c.ambient_K - zero_degC_K;
    json["loss_factor"] = c.loss;
  }
  if (run.strain.count > 0 || imposed) {
    json["strain_zero"] = c.strain_zero;
  }
  if (run.resistance.count > 0) {
    json["resistance_gain"] = c.resistance_gain;
  }
  return json;
}

/// The structures that were judged, each with the observer's mean error in each judged run.
Json judgement_json(const FitResult& fit) {
  const Judgement& judgement = fit.judgement;
  Json all = Json::array();
  const auto by_run = [&](const std::vector<double>& errors) {
    Json percents = Json::object();
    for (std::size_t i = 0; i < errors.size(); ++i) {
      percents[fit.runs[judgement.runs[i]].name] = 100 * errors[i];
    }
    return percents;
  };
  for (const JudgedStructure& judged : judgement.structures) {
    all.push_back(
        {{"structure", structure_name(judged.structure)},
         {"chosen", judged.structure == judgement.chosen()},
         {"observer_error_percent",
          {{"runs_of_the_fit", by_run(judged.seen)}, {"runs_left_out", by_run(judged.unseen)}}}});
  }
  return all;
}

Json parameter_json(const FittedParameter& fitted) {
  const Figure f = figure(fitted);
  return {{"key", fitted.parameter.key},
          {"unit", fitted.parameter.unit},
          {"value", f.value},
          {"sd", f.sd},
          {"prior", f.prior},
          {"prior_sd", f.prior_sd},
          {"uncertainty", fitted.uncertainty},
          {"determined", fitted.determined}};
}

}  // namespace

std::optional<double> joint_rms(const std::vector<FittedRun>& runs,
                                FitQuality FittedRun::* quality) {
  double sum = 0;
  double rows = 0;
  for (const FittedRun& run : runs) {
    const auto count = static_cast<double>((run.*quality).count);
    sum += count * (run.*quality).rms * (run.*quality).rms;
    rows += count;
  }
  return rows > 0 ? std::optional(std::sqrt(sum / rows)) : std::nullopt;
}

double classic_rms(const ClassicFit& classic, const Run& run, double nominal_stroke) {
  const auto [min, max] = std::ranges::minmax(run.strain);
  return classic.rms * (max - min) / nominal_stroke;
}

std::string fit_summary(const Identification& all) {
  std::string text = heading(all) + "\n" + unit_of_errors(all);
  text += (text.ends_with('\n') ? "" : "\n") + runs_table(all).text();
  text += heat_flows(all.fit) + joint_text(all.fit.runs);
  if (all.held_out.size() < all.held_out_runs.size()) {
    text += "runs held out: not predicted, since the fit was interrupted\n";
  }
  if (!all.held_out.empty()) {
    text += fmt::format("{}\n", held_out_heading) + runs_table(all.held_out, {}, {}).text() +
            joint_text(all.held_out);
  }
  text += offset_text(all);
  const std::vector<std::string> lines =
      files::broken("structure: " + structure(all.fit.variant), files::terminal_columns - 2);
  text += fmt::format("{}\n", fmt::join(lines, "\n  ")) + circuit(all.fit);
  if (!all.fit.judgement.structures.empty()) {
    text += fmt::format("{}\n", judgement_heading) + judgement_table(all.fit).text();
  }
  text += judgement_text(all.fit);
  const std::vector<std::string> found = parameters_text(all.fit, true);
  if (!found.empty()) {
    text += fmt::format("determined by these runs:\n  {}\n", fmt::join(found, "\n  "));
  }
  const std::vector<std::string> kept = parameters_text(all.fit, false);
  if (!kept.empty()) {
    text += fmt::format("not determined by these runs, kept from {}:\n  {}\n",
                        files::printable(all.from), fmt::join(kept, "\n  "));
  }
  const std::string correlations = correlations_text(all.fit);
  if (!correlations.empty()) {
    text += "strongly correlated, known in combination rather than singly:\n" + correlations;
  }
  return text;
}

std::string fit_json(const Identification& all) {
  const FitResult& fit = all.fit;
  Json json{{"wire", all.out},
            {"from", all.from},
            {"interrupted", fit.interrupted},
            {"converged", fit.converged},
            {"iterations", fit.iterations},
            {"elapsed_s", all.elapsed_s},
            {"nominal_stroke", fit.wire.nominal_stroke}};
  if (const auto rms = joint_strain_rms(fit)) {
    json["strain_rms_percent"] = 100 * *rms;
  }
  if (const auto rms_Pa = joint_rms(fit.runs, &FittedRun::stress_Pa)) {
    json["stress_rms_MPa"] = 1e-6 * *rms_Pa;
  }
  if (fit.moved_K != 0) {
    json["transitions_moved_K"] = fit.moved_K;
  }
  json["structure"] = {
      {"separate_r2a", fit.variant.separate_r2a},
      {"separate_r2m", fit.variant.separate_r2m},
      {"taper", fit.variant.taper},
      {"memory", fit.variant.memory == Memory::return_point ? "return-point" : "plain"},
      {"loop_order", fit.variant.loop_order},
      {"mixture", fit.variant.mixture == Mixture::series ? "series" : "parallel"}};
  json["structure"]["judged"] = judgement_json(fit);
  json["accuracy"] = {
      {"left_by_the_fit_percent", 100 * fit.strain_sd / fit.wire.nominal_stroke},
      {"of_the_wire_percent", 100 * fit.wire.accuracy.strain / fit.wire.nominal_stroke}};
  if (!std::isnan(fit.share_within_2_sd)) {
    json["accuracy"]["within_2_sd_percent"] = 100 * fit.share_within_2_sd;
  }
  if (fit.circuit_fitted) {
    json["circuit"] = {{"lead_resistance_ohm", fit.circuit.lead_ohm},
                       {"load_gain", fit.circuit.load_gain}};
  }
  json["runs"] = Json::array();
  for (std::size_t i = 0; i < fit.runs.size(); ++i) {
    Json run = run_json(fit.runs[i]);
    for (const ClassicFit& classic : all.classics[i]) {
      run["classic_rms_percent"][std::string(classic.name)] =
          100 * classic_rms(classic, all.runs[i], fit.wire.nominal_stroke);
    }
    json["runs"].push_back(std::move(run));
  }
  for (const FittedRun& run : all.held_out) {
    json["runs_held_out"].push_back(run_json(run));
  }
  json["parameters"] = Json::array();
  for (const FittedParameter& fitted : fit.parameters) {
    json["parameters"].push_back(parameter_json(fitted));
  }
  json["correlations"] = Json::array();
  for (const Correlation& c : fit.correlations) {
    json["correlations"].push_back({{"first", c.first}, {"second", c.second}, {"value", c.value}});
  }
  return files::json_text(json);
}

void write_fit_report(const std::string& path, const Identification& all, Units units) {
  std::string html =
      fmt::format("<p>{}</p>\n<p>{}</p>\n", files::escaped(heading(all)), unit_of_errors(all)) +
      runs_table(all).html();
  for (const std::string& text : {joint_text(all.fit.runs), heat_flows(all.fit), offset_text(all),
                                  "structure: " + structure(all.fit.variant), circuit(all.fit)}) {
    html += text.empty() ? "" : fmt::format("<p>{}</p>\n", files::escaped(text));
  }
  if (!all.held_out.empty()) {
    html += fmt::format("<p>{}</p>\n", held_out_heading) + runs_table(all.held_out, {}, {}).html() +
            fmt::format("<p>{}</p>\n", joint_text(all.held_out));
  }
  if (!all.fit.judgement.structures.empty()) {
    html += fmt::format("<p>{}</p>\n", files::escaped(judgement_heading)) +
            judgement_table(all.fit).html();
  }
  const std::string judgement = judgement_text(all.fit);
  html += judgement.empty() ? "" : fmt::format("<p>{}</p>\n", files::escaped(judgement));
  std::vector<report::Panel> panels = fit_panels(all.fit, all.runs);
  for (report::Panel& panel :
       held_out_panels(all.held_out, all.held_out_runs, all.fit.wire.nominal_stroke)) {
    panels.push_back(std::move(panel));
  }
  html += report::plots_html(panels, units);
  html += parameters_html(all.fit);
  const std::string correlations = correlations_text(all.fit);
  if (!correlations.empty()) {
    html += report::listing_html("Strongly correlated, known in combination rather than singly",
                                 correlations);
  }
  html += report::listing_html("Wire", files::to_toml(all.wire));
  report::write_html(path, all.wire.name, html);
}

}  // namespace smaservo::identify
