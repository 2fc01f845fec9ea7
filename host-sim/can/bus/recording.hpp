#pragma once
// Signals that were recorded at one rate, and their file.

#include <string>
#include <vector>

namespace smaservo::can {

struct Recording {
  std::vector<std::string> signals;
  double period_s = 0;
  std::vector<std::vector<double>> rows;  ///< a column for each signal

  /// Throws UserError for a signal that was not recorded.
  std::vector<double> column(const std::string& signal) const;
};

/// As CSV with a header; times begin at 0.
std::string to_csv(const Recording& recording);
/// Reads a file that to_csv() has made. Throws UserError, also where the rows are not evenly spaced
/// in time.
Recording load_recording(const std::string& path);

}  // namespace smaservo::can
