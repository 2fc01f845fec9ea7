#pragma once
// Reports as one HTML file that opens without a network.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/report/panel.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::report {

/// All panels as pictures, those of half the width side by side, and the data from which a browser
/// draws interactive panels (assets.hpp), if the program contains the script. Throws UserError if
/// gnuplot is missing or fails. The panels are shown in these units.
std::string plots_html(const std::vector<Panel>& panels, Units units);
/// Like plots_html() above, with pictures already drawn, and titles of this heading level.
std::string plots_html(const std::vector<Panel>& panels, const std::vector<std::string>& svg,
                       int heading);

/// A text in its original layout, under a heading.
std::string listing_html(std::string_view heading, std::string_view text);

/// Writes a complete document around the body. Throws UserError.
void write_html(const std::string& path, std::string_view title, std::string_view body);

}  // namespace smaservo::report
