#include "host-sim/report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host-sim/observers.hpp"
#include "host-sim/output_file.hpp"
#include "host-sim/plots.hpp"

namespace smaservo {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t there = std::min<std::size_t>(bytes.size() - i, 3);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (k < there ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += k <= there ? digits[bits >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return out;
}

constexpr const char* head = R"(<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 66rem; margin: 0 auto;
       padding: 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; }
h2 { font-size: 1.15rem; margin: 1.5rem 0 0; }
p { margin: .25rem 0; }
.caption { color: #555; font-size: .9rem; }
table { border-collapse: collapse; margin: .75rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .9rem .2rem 0; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
.lost { color: #b00020; font-weight: bold; }
object { display: block; width: 100%; aspect-ratio: var(--shape); }
.plots { display: flex; flex-wrap: wrap; gap: 0 2%; }
.plots section { width: 100%; break-inside: avoid; }
.plots section.half { width: 49%; }
pre { background: #f6f6f6; padding: .75rem; overflow-x: auto; font-size: .8rem; line-height: 1.35; }
@media (max-width: 40rem) { .plots section.half { width: 100%; } }
@media print { body { max-width: none; font-size: 11px; padding: 0; } pre { white-space: pre-wrap; } }
</style>
)";

std::string shape(const Plot& plot) {
  const auto box = plot.svg.find("viewBox=\"0 0 ");
  if (box == std::string::npos) {
    return "10/3";
  }
  const auto from = box + std::string_view("viewBox=\"0 0 ").size();
  std::string numbers = plot.svg.substr(from, plot.svg.find('"', from) - from);
  const auto space = numbers.find(' ');
  return numbers.replace(space, 1, "/");
}

std::string plots_html(const ReplayResult& result) {
  std::string html = "<div class=\"plots\">\n";
  for (const Plot& plot : draw_plots(result)) {
    html += fmt::format(
        "<section{}><h2>{}</h2>\n<p class=\"caption\">{}</p>\n<object style=\"--shape:{}\" "
        "type=\"image/svg+xml\" aria-label=\"{}\" data=\"data:image/svg+xml;base64,{}\"></object>"
        "</section>\n",
        plot.half_width ? " class=\"half\"" : "", plot.title, plot.caption, shape(plot), plot.title,
        base64(plot.svg));
  }
  return html + "</div>\n";
}

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
  const auto given = [&](std::string_view key) -> const std::string* {
    const std::string* value = nullptr;
    for (const auto& [name, setting] : options.settings) {
      value = name == key ? &setting : value;
    }
    return value;
  };
  for (const ObserverSetting& setting : observer_settings()) {
    const std::string* value = given(setting.key);
    text += value != nullptr
                ? fmt::format("{} = {}  # set, not {:g}\n", setting.key, *value, setting.value)
                : fmt::format("{} = {:g}\n", setting.key, setting.value);
  }
  for (const MeasurementSetting& setting : measurement_settings()) {
    if (const std::string* value = given(setting.key)) {
      text += fmt::format("{} = {}  # set\n", setting.key, *value);
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
  const std::string title = escaped(trace_name(options));
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><title>{}</title>\n{}</head><body>\n", title, head);
  html += fmt::format("<h1>{}</h1>\n<p>{}</p>\n", title, escaped(reading(options, result)));
  html += errors_html(result, options.wire.wire.nominal_stroke);
  html += plots_html(result);
  if (!result.complaints.empty()) {
    html += "<h2>Skipped rows</h2>\n<pre>";
    for (const std::string& complaint : result.complaints) {
      html += escaped(complaint) + "\n";
    }
    html += "</pre>\n";
  }
  html += fmt::format("<h2>Wire</h2>\n<pre>{}</pre>\n", escaped(to_toml(options.wire)));
  html += fmt::format("<h2>Settings</h2>\n<pre>{}</pre>\n", escaped(settings_text(options)));
  html += fmt::format("<p class=\"caption\">Written by host-sim {}.</p>\n</body></html>\n",
                      SMASERVO_VERSION);
  OutputFile file(path);
  file.write(html);
  file.commit();
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
