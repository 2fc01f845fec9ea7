#pragma once
// Reports as one HTML file that opens without a network.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/report/gnuplot.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::report {

/// All plots, those of half the width side by side.
std::string plots_html(const std::vector<Plot>& plots);

/// A text as it stands, under a heading.
std::string listing_html(std::string_view heading, std::string_view text);

/// Writes a complete document around the body. Throws UserError.
void write_html(const std::string& path, std::string_view title, std::string_view body);

}  // namespace smaservo::report
