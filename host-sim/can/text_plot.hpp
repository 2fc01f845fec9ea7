#pragma once

#include <span>
#include <string>

namespace smaservo::can {

/// A curve in letters, `width` by `height`, with its range at the left; columns take the mean of
/// what falls into them. What is not finite leaves a gap.
std::string text_plot(std::span<const double> values, std::size_t width, std::size_t height);

}  // namespace smaservo::can
