#pragma once

#include <string>

namespace smaservo::text {

/// firmware/reference/PARAMETERS.md: every parameter, in Markdown.
std::string parameter_reference();

}  // namespace smaservo::text
