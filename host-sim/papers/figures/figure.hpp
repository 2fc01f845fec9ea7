#pragma once
// The figures of the four papers, drawn again from the project's models, so that whoever holds a
// paper can lay them side by side.

#include <string>
#include <vector>

#include "host-sim/report/panel.hpp"

namespace smaservo::figures {

struct PaperFigure {
  int number;           ///< in its paper
  std::string title;    ///< what the paper's figure shows
  std::string caption;  ///< one line that says what there is to see
  std::vector<report::Panel> panels;
};

struct Paper {
  std::string number;    ///< "000"
  std::string title;     ///< and who wrote it
  std::string left_out;  ///< which figures are not drawn, and why
  std::vector<PaperFigure> (*figures)();
};

// Each throws UserError when gnuplot, which draws surfaces, is missing or fails.
std::vector<PaperFigure> figures_000();  ///< some ten seconds
std::vector<PaperFigure> figures_001();
std::vector<PaperFigure> figures_002();
std::vector<PaperFigure> figures_003();

const std::vector<Paper>& papers();

/// Writes every figure of these papers as SVG files, named after paper and figure (and panel, where
/// there are several), and index.html, into a folder that is made if it is missing.
void write_figures(const std::string& folder, const std::vector<std::string>& paper_numbers);

}  // namespace smaservo::figures
