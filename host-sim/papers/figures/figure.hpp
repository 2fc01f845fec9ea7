#pragma once
// The figures of the four papers, drawn again from the project's models, for comparison with the
// papers.

#include <string>
#include <vector>

#include "host-sim/report/panel.hpp"

namespace smaservo::figures {

struct PaperFigure {
  int number;           ///< number in its paper
  std::string title;    ///< what the paper's figure shows
  std::string caption;  ///< one line on what is to be seen
  std::vector<report::Panel> panels;
};

struct Paper {
  std::string number;    ///< "000"
  std::string title;     ///< title and authors
  std::string left_out;  ///< figures that are not drawn, and why
  std::vector<PaperFigure> (*figures)();
};

// Each throws UserError if gnuplot, which draws surfaces, is missing or fails.
std::vector<PaperFigure> figures_000();  ///< takes some ten seconds
std::vector<PaperFigure> figures_001();
std::vector<PaperFigure> figures_002();
std::vector<PaperFigure> figures_003();

const std::vector<Paper>& papers();

/// Writes every figure of these papers as an SVG file, named after paper and figure (and panel, if
/// there are several), and index.html, into a folder that is created if it is missing.
void write_figures(const std::string& folder, const std::vector<std::string>& paper_numbers);

}  // namespace smaservo::figures
