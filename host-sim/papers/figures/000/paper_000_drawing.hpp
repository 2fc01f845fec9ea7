#pragma once
// Common parts of the drawings of paper 000. Used only in paper_000*.cpp.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/papers/figures/000/paper_000.hpp"
#include "host-sim/papers/figures/figure.hpp"

namespace smaservo::figures::paper_000 {

// The paper's colours.
inline constexpr const char* heating_colour = "heating";
inline constexpr const char* cooling_colour = "cooling";
inline constexpr const char* martensite_colour = "cooling";
inline constexpr const char* austenite_colour = "heating";
inline constexpr const char* r_phase_colour = "planned";

inline constexpr const char* temperature_axis = "temperature in °C";
inline constexpr const char* stress_axis = "stress in MPa";
inline constexpr const char* strain_axis = "strain in %";
inline constexpr const char* resistivity_axis = "specific resistance in µΩm";

using Column = std::vector<double>;

Column degC(const Column& kelvin);
Column times(double factor, const Column& column);

/// The rows that heat (or cool) of a cycle whose hottest row is given.
Column heating_part(const Column& all, std::size_t hottest);
Column cooling_part(const Column& all, std::size_t hottest);

report::Series line(Column x, Column y, std::string colour, std::string name, double width = 1.8);
report::Series dashed(report::Series line);

/// Heating and cooling of a cycle, in the paper's colours, with these names.
std::vector<report::Series> cycle(const Column& x, const Column& y, std::size_t hottest,
                                  const std::string& heating = "heating",
                                  const std::string& cooling = "cooling", double width = 1.8);

/// A dashed vertical line at this temperature.
report::Rule marker(double temperature_K);

/// An axis from `min` to `max`.
report::Axis axis(const char* label, double min = report::as_the_data,
                  double max = report::as_the_data);

/// A panel of half the width, two of which stand side by side.
report::Panel half_panel(std::string title, report::Axis x, report::Axis y,
                         std::vector<report::Series> series, int height = 360);
report::Panel full_panel(std::string title, report::Axis x, report::Axis y,
                         std::vector<report::Series> series, int height = 420);

/// Makes figures 13 to 20.
std::vector<PaperFigure> identified_figures();

}  // namespace smaservo::figures::paper_000
