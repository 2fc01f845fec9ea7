#pragma once

#include <string>

namespace smaservo {

/// firmware/reference/PARAMETERS.md: every parameter, in Markdown.
std::string parameter_reference();

}  // namespace smaservo
