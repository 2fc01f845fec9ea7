#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/recording/trace_file.hpp"

namespace smaservo::replay {

/// One row of an estimate, in SI. NaN is written as an empty field.
struct EstimateRow {
  double time_s;
  double strain, strain_sd;
  double temperature_K;
  double martensite, r_phase;
  double resistance_ohm, resistance_model_ohm;
  bool valid;
  double strain_ref;
};

/// Appends `value` with a fixed number of decimals, rounded to nearest; exact for |value| below
/// 2^53 / 10^decimals, by the shortest text above. Nothing for NaN. Returns the end.
/// A tenth of the time of the standard's formatting, which would be most of a replay's.
char* append_fixed(char* to, double value, int decimals);

/// The file that a replay writes, as CSV or MCAP.
class EstimateFile {
 public:
  /// `source` is the trace's name. `passed` are names of further columns, whose texts add() takes
  /// over from the trace's row.
  EstimateFile(const std::string& path, const std::string& source, bool has_reference,
               const std::vector<std::string>& passed, std::vector<std::size_t> positions);

  void add(const EstimateRow& row, std::string_view trace_row);
  void commit();

 private:
  hal::TraceFile file_;
  bool has_reference_;
  std::vector<std::size_t> positions_;
  std::vector<char> buffer_;
  std::size_t used_ = 0;
};

}  // namespace smaservo::replay
