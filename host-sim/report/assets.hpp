#pragma once
// What npm has built of host-sim/page/front, inside of the program.

#include <string_view>

namespace smaservo::report {

/// The page of `host-sim page`: one HTML document. Empty where the program was built without npm.
std::string_view page_html();

/// What makes a report's panels interactive: one script without modules. Empty in the same case:
/// reports then show pictures.
std::string_view report_script();

}  // namespace smaservo::report
