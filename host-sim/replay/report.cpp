#include "host-sim/replay/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host-sim/replay/observers.hpp"
#include "host-sim/replay/plots.hpp"
#include "host-sim/report/html.hpp"
#include "observer/kalman.hpp"

namespace smaservo {
namespace {

std::string errors_html(const ReplayResult& result, double stroke) {
  if (!result.has_reference) {
    return "<p>The trace has no reference, so no error can be given.</p>\n";
  }
  std::string html = fmt::format(
      "<table><tr><th>error in % of the nominal stroke ({:g} % strain)</th><th>mean</th><th>95 %"
      "</th><th>maximum</th></tr>\n",
      100 * stroke);
  for (const ObserverResult& observer : result.observers) {
    const ErrorStatistics& e = observer.error;
    html += fmt::format("<tr><td>{}{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td></tr>\n",
                        escaped(observer.name),
                        observer.lost ? " <span class=\"lost\">lost</span>" : "", e.mean(),
                        e.quantile(0.95), e.maximum());
  }
  html += "</table>\n";
  html +=
      "<p class=\"caption\">Plots show the first one. Lost: more than 20 % off after the first "
      "second.</p>\n";
  return html;
}

std::string settings_text(const ReplayOptions& options) {
  std::string text;
  const RunSettings settings = parse_run_settings(options.settings);
  const KalmanTuning<double> defaults = kalman_tuning(options.wire.wire.accuracy);
  for (const auto& [field, member] : run_keys()) {
    const auto given = settings.find(field.slot);
    const std::string key = key_with(field.path, field.kind.front().suffix);
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
  text += fmt::format(", wire {}", options.wire.name);
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
    text += fmt::format(", started again after {} gaps", result.restarts);
  }
  return text;
}

std::string trace_name(const ReplayOptions& options) {
  return options.trace == "-" ? "standard input" : options.trace;
}

}  // namespace

void write_report(const std::string& path, const ReplayOptions& options,
                  const ReplayResult& result) {
  std::string html = fmt::format("<p>{}</p>\n", escaped(reading(options, result)));
  html += errors_html(result, options.wire.wire.nominal_stroke);
  html += plots_html(draw_plots(result));
  if (!result.complaints.empty()) {
    html += listing_html("Skipped rows", fmt::format("{}\n", fmt::join(result.complaints, "\n")));
  }
  html += listing_html("Wire", to_toml(options.wire));
  html += listing_html("Settings", settings_text(options));
  write_html(path, trace_name(options), html);
}

std::string summary(const ReplayOptions& options, const ReplayResult& result) {
  std::string text = fmt::format("{}: {}\n", trace_name(options), reading(options, result));
  for (const std::string& complaint : result.complaints) {
    text += fmt::format("  skipped: {}\n", complaint);
  }
  if (!result.has_reference) {
    return text + "no strain_ref or displacement in the trace: no error can be given\n";
  }
  text +=
      fmt::format("error in % of the nominal stroke ({:g} % strain)\n{:<12}{:>8}{:>8}{:>9}\n",
                  100 * options.wire.wire.nominal_stroke, "observer", "mean", "95 %", "maximum");
  for (const ObserverResult& observer : result.observers) {
    const ErrorStatistics& e = observer.error;
    text += fmt::format("{:<12}{:>8.2f}{:>8.2f}{:>9.2f}{}\n", observer.name, e.mean(),
                        e.quantile(0.95), e.maximum(), observer.lost ? "  lost" : "");
  }
  return text;
}

std::string summary_json(const ReplayOptions& options, const ReplayResult& result) {
  nlohmann::ordered_json json{
      {"trace", options.trace},          {"wire", options.wire.name},
      {"model_alone", result.open_loop}, {"rows", result.rows},
      {"skipped_rows", result.skipped},  {"complaints", result.complaints},
      {"invalid_rows", result.invalid},  {"restarts", result.restarts},
      {"bytes", result.bytes},           {"duration_s", result.duration_s},
      {"elapsed_s", result.elapsed_s},   {"nominal_stroke", options.wire.wire.nominal_stroke}};
  if (result.has_reference) {
    nlohmann::ordered_json errors;
    for (const ObserverResult& observer : result.observers) {
      errors[observer.name] = {{"mean_percent", observer.error.mean()},
                               {"p95_percent", observer.error.quantile(0.95)},
                               {"max_percent", observer.error.maximum()},
                               {"lost", observer.lost}};
    }
    json["error"] = errors;
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace smaservo
