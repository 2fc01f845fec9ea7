#pragma once
// What node has built, as parts of the program.

#include <string_view>

namespace smaservo::report {

/// The page of `host-sim page`, one HTML file; "" where it was built without node.
std::string_view page_html();

}  // namespace smaservo::report
