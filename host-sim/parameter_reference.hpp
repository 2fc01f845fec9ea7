#pragma once

#include <string>

namespace smaservo {

/// firmware/PARAMETERS.md: every parameter, in Markdown.
std::string parameter_reference();

}  // namespace smaservo
