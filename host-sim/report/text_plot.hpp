#pragma once

#include <string>
#include <vector>

namespace smaservo::report {

/// Curves in letters, `width` by `height`, with their range at the left: the first one of stars,
/// the others of dots below it. Columns take the mean of what falls into them. What is not finite
/// leaves a gap.
std::string text_plot(const std::vector<std::vector<double>>& curves, std::size_t width,
                      std::size_t height);

}  // namespace smaservo::report
