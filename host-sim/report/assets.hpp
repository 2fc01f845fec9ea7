#pragma once
// Files that npm has built from host-sim/page/front, as parts of the program.

#include <string_view>

namespace smaservo::report {

/// The page of `host-sim page`: one HTML document. Empty if the program was built without npm.
std::string_view page_html();

/// The script that makes a report's panels interactive, without modules. Empty if the program was
/// built without npm: reports then show pictures.
std::string_view report_script();

}  // namespace smaservo::report
