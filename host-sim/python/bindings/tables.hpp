#pragma once
// Tables of numbers that Python has: rows as the readers of files give them.

#include <optional>
#include <pybind11/numpy.h>
#include <span>
#include <string>
#include <vector>

#include "hal/replay/trace_columns.hpp"
#include "host-sim/python/bindings/wire.hpp"

namespace smaservo::python {

using Array = py::array_t<double, py::array::c_style>;

/// Columns of equal length and their names; the numbers stay those of Python's arrays.
class Table {
 public:
  /// `names` are understood as those of a file's header. An array without numbers stands for a
  /// column that is no numbers, which none that is understood may be (TypeError). Throws UserError.
  Table(const std::vector<std::string>& names, const std::vector<Array>& arrays,
        const hal::TraceOptions& options);

  std::size_t rows() const { return rows_; }
  const hal::TraceColumns& columns() const { return columns_; }
  /// The columns that rows have, as Recorder wants them.
  std::vector<hal::Column> known() const;

  /// Rows one after another, as hal::TraceReader has next(); false at the end. Throws ValueError
  /// (std::invalid_argument) for a number that is not allowed, and where the time does not rise.
  /// Needs no GIL.
  bool next(hal::TraceRow& row);

 private:
  hal::TraceColumns columns_;
  std::vector<std::span<const double>> values_;
  std::vector<std::size_t> used_;  ///< the columns that are understood
  std::vector<double> numbers_;
  std::size_t rows_ = 0;
  std::size_t at_ = 0;
  double last_s_ = 0;
};

/// All options of a reader that Python may give.
hal::TraceOptions trace_options(bool lenient, std::optional<double> period_s,
                                const std::vector<std::string>& columns);

/// What a reader has to say of a file: read_as, hints, skipped, complaints, clock_notes.
py::dict notes_of(const hal::TraceReader& trace);

}  // namespace smaservo::python
