#pragma once
// What the files that draw paper 002's figures share.

#include <string>
#include <vector>

#include "host-sim/papers/figures/002/rig_002.hpp"
#include "host-sim/papers/figures/figure.hpp"

namespace smaservo::figures::bench_002 {

/// The figures of sections 3 and 4.1 to 4.3, and of sections 4.5 to 6.
std::vector<PaperFigure> characterisation_figures(const fits::StrainResistanceFit& fit);
std::vector<PaperFigure> model_figures(const fits::StrainResistanceFit& fit);

/// The wires of the figures.
inline constexpr hal::Family shown_family = hal::Family::ihyp;

/// Elongation, as displacement of the wire's end.
double displacement_mm(double strain);

/// A named data block of gnuplot; each row's numbers, and empty rows as gaps.
std::string data_block(const std::string& name, const std::vector<std::vector<double>>& rows);

report::Plot wide(std::string title, const std::string& x, const std::string& y,
                  const std::string& data, const std::vector<std::string>& curves,
                  const std::string& more = "");
report::Plot half(std::string title, const std::string& x, const std::string& y,
                  const std::string& data, const std::vector<std::string>& curves,
                  const std::string& more = "");

inline constexpr const char* ohm_label = "resistance in Ω";
inline constexpr const char* mm_label = "displacement in mm";
inline constexpr const char* red = "'#c0392b'";
inline constexpr const char* blue = "'#2471a3'";

}  // namespace smaservo::figures::bench_002
