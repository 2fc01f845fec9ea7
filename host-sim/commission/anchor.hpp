#pragma once
// Readings of a caliper, a ruler, a switch or a hard stop that go with a recorded run.

#include <string>
#include <string_view>
#include <vector>

namespace smaservo::commission {

/// One reading of where the wire's end was.
struct Anchor {
  double time_s;          ///< in the run file's own time
  double displacement_m;  ///< contraction: it grows as the wire gets shorter
  double sd_m;            ///< standard deviation of the reading
};

/// Where the displacement 0 of all readings is.
enum class Zero : unsigned char {
  /// Anywhere, at the same place for all of them: only differences between readings count.
  common,
  /// Where the wire has exactly the length of the wire file. A longer wire has a negative
  /// displacement.
  length
};

/// The standard deviation of a reading that is given without one: between that of a caliper and
/// that of a ruler.
inline constexpr double usual_anchor_sd_m = 0.1e-3;

/// Reads "TIME_S,DISPLACEMENT_MM" or "TIME_S,DISPLACEMENT_MM,SD_MM"; `sd_m` is that of a reading
/// without one. Throws UserError for anything that is not two or three finite numbers, and for a
/// deviation that is not greater than 0.
Anchor parse_anchor(std::string_view text, double sd_m);

/// Reads a file of readings: a trace (hal/replay/README.md) with the columns `time` and
/// `displacement`, and perhaps `sd_mm` or `sd_m`; without it `sd_m` is the deviation of all. Rows
/// without a displacement do not count. Throws UserError or TraceError, which name file and line.
std::vector<Anchor> read_anchors(const std::string& path, double sd_m);

}  // namespace smaservo::commission
