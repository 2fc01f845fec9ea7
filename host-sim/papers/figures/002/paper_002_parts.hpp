#pragma once
// Common parts of the files that draw the figures of paper 002.

#include <string>
#include <vector>

#include "host-sim/papers/figures/002/rig_002.hpp"
#include "host-sim/papers/figures/figure.hpp"

namespace smaservo::figures::bench_002 {

/// The first function makes the figures of sections 3 and 4.1 to 4.3, the second those of sections
/// 4.5 to 6.
std::vector<PaperFigure> characterisation_figures(const fits::StrainResistanceFit& fit);
std::vector<PaperFigure> model_figures(const fits::StrainResistanceFit& fit);

/// The family of the wires in the figures.
inline constexpr hal::Family shown_family = hal::Family::ihyp;

/// Elongation as a displacement of the wire's end.
double displacement_mm(double strain);

report::Panel wide(std::string title, const char* x, const char* y,
                   std::vector<report::Series> series);
report::Panel half(std::string title, const char* x, const char* y,
                   std::vector<report::Series> series);

/// Colour of loops under several loads: heating red, cooling blue, dark for heavy loads.
std::string shade_of(double stress_MPa, bool heats);

inline constexpr const char* ohm_label = "resistance in Ω";
inline constexpr const char* mm_label = "displacement in mm";
}  // namespace smaservo::figures::bench_002
