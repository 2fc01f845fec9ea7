#pragma once

#include <string>
#include <vector>

namespace smaservo::report {

/// Curves as text of `width` by `height` characters, with their range at the left: the first curve
/// in stars, the others in dots behind it. A column shows the mean of its values. Values that are
/// not finite leave a gap.
std::string text_plot(const std::vector<std::vector<double>>& curves, std::size_t width,
                      std::size_t height);

}  // namespace smaservo::report
