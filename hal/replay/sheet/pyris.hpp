#pragma once
// Text that Pyris, the program of PerkinElmer's differential scanning calorimeters, exports of a
// measurement: a page about sample and method, then the rows, divided into numbered steps.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::hal {

/// The rows of such an export as those of a calorimeter's trace. Only rows of a temperature scan
/// are taken, from where the sample follows the program: in a hold, and while the furnace gets to
/// its rate, the flow of heat says nothing about the sample's capacity.
class PyrisExport {
 public:
  /// The export whose beginning these lines are; none if they are something else. Throws UserError
  /// where one does not tell the sample's weight, or lacks a column that is needed.
  static std::optional<PyrisExport> find(const std::vector<std::string_view>& lines);

  /// The number of the first line that may be a row, from 1.
  std::size_t first() const { return first_; }
  /// The columns that take() makes, as this project's traces name them.
  static std::vector<std::string> names() {
    return {"time_s", "temperature_degC", "power_W_per_g"};
  }
  /// Takes the next line of the file. Returns whether it is a row of the trace, which `row` is
  /// then.
  bool take(std::string_view line, std::vector<std::string>& row);
  /// "export of Pyris, 60.2 mg, scans without their holds, heat flow less its baseline".
  std::string said() const;

 private:
  /// Columns of the file.
  enum Column : unsigned char { time, flow, baseline, program, sample, place_count };

  void find_columns(const std::vector<std::string_view>& lines, std::size_t heading);
  void find_weight(const std::vector<std::string_view>& lines, std::size_t heading);
  bool follows(const std::array<double, place_count>& row);

  std::size_t first_ = 0;
  std::array<std::size_t, place_count> columns_{};  ///< places of the columns
  std::size_t fields_ = 0;                          ///< of a row
  bool has_baseline_ = false;
  char decimal_ = '.';
  double weight_mg_ = 0;
  bool scans_ = false;    ///< the present step is a temperature scan
  bool follows_ = false;  ///< in this step, the sample has reached the program's rate
  std::optional<std::array<double, place_count>> before_;  ///< the row before, of this step
};

}  // namespace smaservo::hal
