#pragma once
// Reports as one HTML file that opens without a network.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/report/panel.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::report {

/// All panels as pictures, those of half the width side by side, and the data from which a browser
/// draws them again to be explored (assets.hpp), if the program has what draws them. Throws
/// UserError when gnuplot is missing or fails.
std::string plots_html(const std::vector<Panel>& panels);
/// The same with pictures that have been drawn, and titles of this level.
std::string plots_html(const std::vector<Panel>& panels, const std::vector<std::string>& svg,
                       int heading);

/// A text as it stands, under a heading.
std::string listing_html(std::string_view heading, std::string_view text);

/// Writes a complete document around the body. Throws UserError.
void write_html(const std::string& path, std::string_view title, std::string_view body);

}  // namespace smaservo::report
