#include "host-sim/replay/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host-sim/replay/observers.hpp"
#include "host-sim/replay/plots.hpp"
#include "host-sim/report/html.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"
#include "observer/kalman.hpp"

namespace smaservo::replay {
namespace {

files::TextTable errors(const ReplayResult& result) {
  files::TextTable table({{"observer"},
                          {"mean", "{:.2f}", "mean_percent"},
                          {"95 %", "{:.2f}", "p95_percent"},
                          {"maximum", "{:.2f}", "max_percent"},
                          {""},
                          {.key = "lost"}});
  for (const ObserverResult& observer : result.observers) {
    const ErrorStatistics& e = observer.error;
    table.add({observer.name,
               e.mean(),
               e.quantile(0.95),
               e.maximum(),
               {observer.lost ? "lost" : "", observer.lost},
               observer.lost});
  }
  return table;
}

/// The unit of the errors.
std::string unit_of_errors(const ReplayOptions& options) {
  return fmt::format("error in % of the nominal stroke ({:g} % strain)",
                     100 * options.wire.wire.nominal_stroke);
}

std::string errors_html(const ReplayOptions& options, const ReplayResult& result) {
  return result.has_reference
             ? fmt::format(
                   "<p>{}</p>\n{}<p class=\"caption\">Plots show the first one. Lost: more "
                   "than 20 % off after the first second.</p>\n",
                   unit_of_errors(options), errors(result).html())
             : "<p>The trace has no reference, so no error can be given.</p>\n";
}

std::string settings_text(const ReplayOptions& options) {
  std::string text;
  const RunSettings settings = parse_run_settings(options.settings);
  const KalmanTuning<double> defaults = kalman_tuning(options.wire.wire.accuracy);
  for (const auto& [field, member] : run_keys()) {
    const auto given = settings.find(field.slot);
    const std::string key = files::key_with(field.path, field.kind.front().suffix);
    const auto* const tuning = std::get_if<double KalmanTuning<double>::*>(&member);
    const std::string otherwise = tuning == nullptr ? "" : fmt::format("{:g}", defaults.**tuning);
    if (given != settings.end()) {
      text += fmt::format("{} = {}  # set{}{}\n", key, given->second.number,
                          tuning == nullptr ? "" : ", not ", otherwise);
    } else if (tuning != nullptr) {
      text += fmt::format("{} = {}\n", key, otherwise);
    }
  }
  return text;
}

/// One line: what was read.
std::string reading(const ReplayOptions& options, const ReplayResult& result) {
  std::string text = fmt::format("{} rows", result.rows);
  if (result.timed) {
    text += fmt::format(", {:.4g} s", result.duration_s);
  }
  text += fmt::format(", wire {}", files::printable(options.wire.name));
  if (result.open_loop) {
    text += ", temperature and stress given: the model alone";
  }
  if (result.skipped > 0) {
    text += fmt::format(", {} bad rows skipped", result.skipped);
  }
  if (result.invalid > 0) {
    text += fmt::format(", {} rows without a valid resistance", result.invalid);
  }
  if (result.restarts > 0) {
    text += fmt::format(", started again after {} gap{}", result.restarts,
                        result.restarts == 1 ? "" : "s");
  }
  return text;
}

std::string trace_name(const ReplayOptions& options) {
  return options.trace == "-" ? "standard input" : files::printable(options.trace);
}

}  // namespace

void write_report(const std::string& path, const ReplayOptions& options, const ReplayResult& result,
                  Units units) {
  std::string html = fmt::format("<p>{}</p>\n", files::escaped(reading(options, result)));
  html += errors_html(options, result);
  html += report::plots_html(panels_of(result), units);
  if (!result.complaints.empty()) {
    html += report::listing_html("Skipped rows",
                                 fmt::format("{}\n", fmt::join(result.complaints, "\n")));
  }
  if (!result.clock_notes.empty()) {
    html +=
        report::listing_html("The clock", fmt::format("{}\n", fmt::join(result.clock_notes, "\n")));
  }
  html += report::listing_html("Wire", files::to_toml(options.wire));
  html += report::listing_html("Settings", settings_text(options));
  report::write_html(path, trace_name(options), html);
}

std::string summary(const ReplayOptions& options, const ReplayResult& result) {
  std::string text = fmt::format("{}: {}\n", trace_name(options), reading(options, result));
  for (const std::string& complaint : result.complaints) {
    text += fmt::format("  skipped: {}\n", complaint);
  }
  for (const std::string& note : result.clock_notes) {
    text += fmt::format("  {}\n", note);
  }
  if (!result.has_reference) {
    return text + "no strain_ref or displacement in the trace: no error can be given\n";
  }
  return text + unit_of_errors(options) + "\n" + errors(result).text();
}

nlohmann::ordered_json summary_object(const ReplayOptions& options, const ReplayResult& result) {
  nlohmann::ordered_json json{{"trace", options.trace},
                              {"wire", options.wire.name},
                              {"model_alone", result.open_loop},
                              {"rows", result.rows},
                              {"skipped_rows", result.skipped},
                              {"complaints", result.complaints},
                              {"clock", result.clock_notes},
                              {"invalid_rows", result.invalid},
                              {"restarts", result.restarts},
                              {"bytes", result.bytes},
                              {"duration_s", result.duration_s},
                              {"elapsed_s", result.elapsed_s},
                              {"nominal_stroke", options.wire.wire.nominal_stroke}};
  if (result.has_reference) {
    const nlohmann::ordered_json rows = errors(result).json();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      json["error"][result.observers[i].name] = rows[i];
    }
  }
  return json;
}

std::string summary_json(const ReplayOptions& options, const ReplayResult& result) {
  return files::json_text(summary_object(options, result));
}

}  // namespace smaservo::replay
