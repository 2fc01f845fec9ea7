#include "host-sim/report/html.hpp"

#include <cstdint>
#include <fmt/format.h>

#include "host-sim/report/assets.hpp"
#include "host-sim/report/panel_json.hpp"
#include "host-sim/report/picture.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::report {
namespace {

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

// `light-dark` is too new for the browsers of Debian 12, so colours are listed twice.
constexpr const char* head = R"(<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:;
 style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<style>
body { font: 16px/1.5 system-ui, sans-serif; color: var(--text); background: var(--page);
       max-width: 66rem; margin: 0 auto; padding: 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.5rem; margin-bottom: 0; }
h2, h3, h4 { font-size: 1.15rem; margin: 1.5rem 0 0; }
h4 { font-size: 1rem; margin-top: 1rem; }
p { margin: .25rem 0; }
.caption { color: var(--soft); font-size: .9rem; }
table { border-collapse: collapse; margin: .75rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .9rem .2rem 0; text-align: right; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; }
.lost { color: var(--plot-fault); font-weight: bold; }
img { display: block; width: 100%; aspect-ratio: var(--shape); background: #fff; }
.plots { display: flex; flex-wrap: wrap; gap: 0 2%; }
.plots section { width: 100%; break-inside: avoid; min-width: 0; }
.plots section.half { width: 49%; }
pre { background: var(--sheet); padding: .75rem; overflow-x: auto; font-size: .8rem;
      line-height: 1.35; }
@media screen { .live > img { display: none; } table { display: block; overflow-x: auto; } }
@media (max-width: 40rem) { .plots section.half { width: 100%; } }
@media print { body { max-width: none; font-size: 11px; padding: 0; } pre { white-space: pre-wrap; }
  tr { break-inside: avoid; } h2, h3, h4 { break-after: avoid; } .live > :not(h2, h3, h4, p, img),
  .screen { display: none; } }
</style>
)";

/// The colours of pages and panels as properties of the page: for paper and light screens, and for
/// dark ones.
std::string colours_css() {
  std::string light = "--text: #222; --soft: #555; --page: #fff; --sheet: #f6f6f6; --line: #ddd; ";
  std::string dark =
      "--text: #e8edf3; --soft: #9aa7b5; --page: #161c23; --sheet: #1e262f; --line: #2f3945; ";
  for (const Role& role : colours()) {
    light += fmt::format("--plot-{}: {}; ", role.name, role.light);
    dark += fmt::format("--plot-{}: {}; ", role.name, role.dark);
  }
  return fmt::format(
      "<style>\n:root {{ {}}}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {}}} "
      "}}\n</style>\n",
      light, dark);
}

constexpr std::string_view data_element = R"(<script type="application/json" class="panels">)";

}  // namespace

// Uses <img> instead of <object>, because Chromium leaves some documents unpainted if there are
// many objects.
std::string plots_html(const std::vector<Panel>& panels, const std::vector<std::string>& svg,
                       int heading) {
  std::string html = "<div class=\"plots\">\n";
  if (!report_script().empty()) {
    html += fmt::format("{}{}</script>\n", data_element, panels_json(panels));
  }
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Panel& panel = panels[i];
    const std::string title = files::escaped(panel.title);
    html += fmt::format("<section{}><h{}>{}</h{}>\n", panel.half_width ? " class=\"half\"" : "",
                        heading, title, heading);
    if (!panel.caption.empty()) {
      html += fmt::format("<p class=\"caption\">{}</p>\n", files::escaped(panel.caption));
    }
    html += fmt::format(
        "<img style=\"--shape:{}/{}\" alt=\"{}\" src=\"data:image/svg+xml;base64,{}\"></section>\n",
        panel.half_width ? 500 : 1000, panel.height, title, base64(svg[i]));
  }
  return html + "</div>\n";
}

std::string plots_html(const std::vector<Panel>& panels, Units units) {
  const std::vector<Panel> shown = in_units(panels, units);
  return plots_html(shown, pictures(shown), 2);
}

std::string listing_html(std::string_view heading, std::string_view text) {
  return fmt::format("<h2>{}</h2>\n<pre>{}</pre>\n", files::escaped(heading), files::escaped(text));
}

void write_html(const std::string& path, std::string_view title, std::string_view body) {
  const std::string name = files::escaped(title);
  files::OutputFile file(path);
  file.write(
      fmt::format("<!doctype html>\n<html lang=\"en\"><head><title>{}</title>\n{}{}</head><body>\n"
                  "<h1>{}</h1>\n",
                  name, head, colours_css(), name));
  file.write(body);
  const bool has_panels = body.find(data_element) != std::string_view::npos;
  file.write(fmt::format("<p class=\"caption\">Written by host-sim {}.</p>\n{}</body></html>\n",
                         SMASERVO_VERSION,
                         has_panels ? fmt::format("<script>{}</script>\n", report_script()) : ""));
  file.commit();
}

}  // namespace smaservo::report
