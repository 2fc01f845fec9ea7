#pragma once
// Signals recorded at one rate, and their file.

#include <string>
#include <vector>

namespace smaservo::can {

struct Recording {
  std::vector<std::string> signals;
  double period_s = 0;
  std::vector<std::vector<double>> rows;  ///< each row has a value for each signal
  /// Lines that the file has before its header, each after "# ".
  std::vector<std::string> comments = {};  // NOLINT(readability-redundant-member-init)

  /// Throws UserError if the signal was not recorded.
  std::vector<double> column(const std::string& signal) const;
};

/// The recording as CSV: comments, a header, rows; times begin at 0.
std::string to_csv(const Recording& recording);
/// Reads a file made by to_csv(). Throws UserError, also if the rows are not evenly spaced in time.
Recording load_recording(const std::string& path);

}  // namespace smaservo::can
