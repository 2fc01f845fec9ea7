#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host-sim/papers/figures/figure.hpp"
#include "host-sim/report/html.hpp"
#include "host-sim/report/picture.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::figures {
namespace {

void write_file(const std::filesystem::path& path, std::string_view text) {
  files::OutputFile file(path.string());
  file.write(text);
  file.commit();
}

/// The file name of a panel, such as "001-04.svg" or "001-04-b.svg".
std::string file_name(const Paper& paper, const PaperFigure& figure, std::size_t panel) {
  const std::string letter =
      figure.panels.size() > 1 ? fmt::format("-{}", static_cast<char>('a' + panel)) : "";
  return fmt::format("{}-{:02}{}.svg", paper.number, figure.number, letter);
}

std::string figure_html(const Paper& paper, const PaperFigure& figure,
                        const std::vector<std::string>& svg) {
  return fmt::format("<h3>{}, figure {}: {}</h3>\n<p class=\"caption\">{}</p>\n{}", paper.number,
                     figure.number, files::escaped(figure.title), files::escaped(figure.caption),
                     report::plots_html(figure.panels, svg, 4));
}

}  // namespace

const std::vector<Paper>& papers() {
  static const std::vector<Paper> all{
      {"000", "three-phase model of a SmartFlex wire's strain and resistance",
       "doi:10.1177/1045389X261417975. A simulated wire, which is not the model, takes the "
       "place of the measurements. Not drawn: schemes (3, 4, 7), the bench (11) and its procedure "
       "(12).",
       figures_000},
      {"001", "Differential Hysteresis Modeling of a Shape Memory Alloy Wire Actuator",
       "Left out: 1, 2, 3, 8 and 10, schematics; 6, the slopes that figure 7 integrates; measured "
       "curves of 5, 13, 14 and 15, which the paper does not print as numbers.",
       figures_001},
      {"002",
       "Characterization, Modeling, and Control of Ni-Ti Shape Memory Alloy based on Electrical "
       "Resistance Feedback",
       "Figures 1 and 20 are a photograph and a block diagram, 3 is a sketch of figure 2. Figures "
       "10 and 11 overlay wires of several lengths, which differ here in their cold ends alone.",
       figures_002},
      {"003",
       "System Identification of a NiTi-Based SMA Actuator (Toledo, Ge, Oxoby, Chen, "
       "Pérez-Arancibia)",
       "Figure 1, the experimental setup, is a drawing and a photograph.", figures_003}};
  return all;
}

void write_figures(const std::string& folder, const std::vector<std::string>& paper_numbers) {
  std::vector<std::string_view> known;
  for (const Paper& paper : papers()) {
    known.emplace_back(paper.number);
  }
  for (const std::string& number : paper_numbers) {
    if (std::ranges::count(known, number) == 0) {
      throw files::UserError(
          fmt::format("--paper {}: no such paper; there are: {}", number, fmt::join(known, ", ")));
    }
  }
  files::prepare_folder("--out", folder);
  std::string html;
  for (const Paper& paper : papers()) {
    if (!paper_numbers.empty() && std::ranges::count(paper_numbers, paper.number) == 0) {
      continue;
    }
    html += fmt::format("<h2>Paper {}: {}</h2>\n<p>{}</p>\n", paper.number,
                        files::escaped(paper.title), files::escaped(paper.left_out));
    for (const PaperFigure& figure : paper.figures()) {
      const std::vector<std::string> svg = report::pictures(figure.panels);
      for (std::size_t panel = 0; panel < svg.size(); ++panel) {
        write_file(std::filesystem::path(folder) / file_name(paper, figure, panel), svg[panel]);
      }
      html += figure_html(paper, figure, svg);
    }
  }
  report::write_html((std::filesystem::path(folder) / "index.html").string(), "The papers' figures",
                     html);
}

}  // namespace smaservo::figures
