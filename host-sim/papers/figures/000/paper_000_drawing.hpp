#pragma once
// What the drawings of paper 000 have in common. Used inside of paper_000*.cpp only.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/papers/figures/000/paper_000.hpp"
#include "host-sim/papers/figures/figure.hpp"

namespace smaservo::figures::paper_000 {

// The paper's colours.
inline constexpr const char* heating_colour = "'#c8102e'";
inline constexpr const char* cooling_colour = "'#0059b3'";
inline constexpr const char* martensite_colour = "'#0059b3'";
inline constexpr const char* austenite_colour = "'#c8102e'";
inline constexpr const char* r_phase_colour = "'#2e8b3d'";
inline constexpr const char* model_colour = "'#111111'";

inline constexpr const char* temperature_axis = "temperature in °C";
inline constexpr const char* stress_axis = "stress in MPa";
inline constexpr const char* strain_axis = "strain in %";
inline constexpr const char* resistivity_axis = "specific resistance in µΩm";

using Column = std::vector<double>;

Column degC(const Column& kelvin);
Column times(double factor, const Column& column);

/// Columns of one length as gnuplot's data block `$name`.
std::string block(std::string_view name, const std::vector<Column>& columns);

/// `$name` with the columns T in °C, strain in %, resistivity in µΩm, resistance in Ω, red, green
/// and blue (0 to 255) by fractions of austenite, R-phase and martensite.
std::string bath_block(std::string_view name, const BathRun& run);

/// The rows of a block that heat or cool, for a cycle with this hottest row.
std::string heating_rows(std::size_t hottest);
std::string cooling_rows(std::size_t hottest);

/// "$name using 1:2 ... with lines ..."
std::string line(std::string_view data, std::string_view columns, std::string_view colour,
                 std::string_view title, std::string_view more = "");

/// A dashed vertical line at this temperature.
std::string marker(double temperature_K);

/// Two of these stand side by side.
report::Plot half_panel(std::string title, std::string caption, const char* x_label,
                        const char* y_label, const std::string& data, const std::string& more,
                        const std::vector<std::string>& curves, int height = 360);
report::Plot full_panel(std::string title, std::string caption, const char* x_label,
                        const char* y_label, const std::string& data, const std::string& more,
                        const std::vector<std::string>& curves, int height = 420);

/// Figures 13 to 20.
std::vector<PaperFigure> identified_figures();

}  // namespace smaservo::figures::paper_000
