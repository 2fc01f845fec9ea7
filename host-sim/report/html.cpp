#include "host-sim/report/html.hpp"

#include <cstdint>
#include <fmt/format.h>

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
img { display: block; width: 100%; aspect-ratio: var(--shape); }
.plots { display: flex; flex-wrap: wrap; gap: 0 2%; }
.plots section { width: 100%; break-inside: avoid; }
.plots section.half { width: 49%; }
pre { background: #f6f6f6; padding: .75rem; overflow-x: auto; font-size: .8rem; line-height: 1.35; }
@media (max-width: 40rem) { .plots section.half { width: 100%; } }
@media print { body { max-width: none; font-size: 11px; padding: 0; } pre { white-space: pre-wrap; }
  tr { break-inside: avoid; } h2 { break-after: avoid; } }
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

}  // namespace

// An <img>, not an <object>: Chromium leaves some of the documents that many objects hold
// unpainted.
std::string plots_html(const std::vector<Plot>& plots) {
  std::string html = "<div class=\"plots\">\n";
  for (const Plot& plot : plots) {
    html += fmt::format(
        "<section{}><h2>{}</h2>\n<p class=\"caption\">{}</p>\n<img style=\"--shape:{}\" alt=\"{}\" "
        "src=\"data:image/svg+xml;base64,{}\"></section>\n",
        plot.half_width ? " class=\"half\"" : "", files::escaped(plot.title),
        files::escaped(plot.caption), shape(plot), files::escaped(plot.title), base64(plot.svg));
  }
  return html + "</div>\n";
}

std::string listing_html(std::string_view heading, std::string_view text) {
  return fmt::format("<h2>{}</h2>\n<pre>{}</pre>\n", files::escaped(heading), files::escaped(text));
}

void write_html(const std::string& path, std::string_view title, std::string_view body) {
  const std::string name = files::escaped(title);
  files::OutputFile file(path);
  file.write(fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><title>{}</title>\n{}</head><body>\n"
      "<h1>{}</h1>\n{}<p class=\"caption\">Written by host-sim {}.</p>\n</body></html>\n",
      name, head, name, body, SMASERVO_VERSION));
  file.commit();
}

}  // namespace smaservo::report
