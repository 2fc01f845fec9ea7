#pragma once
// The columns of a trace: what its header says, and the values of a row.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/trace.hpp"
#include "model/units.hpp"

namespace smaservo::hal {

/// Why a row is a bad one.
struct BadRow {
  std::size_t column;
  std::string reason;
};

class TraceColumns {
 public:
  /// `place` is what messages call the header. Throws UserError, which does not name the file.
  TraceColumns(std::string_view header, const TraceOptions& options, std::string place);

  bool has(Column column) const { return has_[static_cast<std::size_t>(column)]; }
  /// Where the file has this column, which it must have.
  std::size_t position(Column column) const;
  const std::vector<std::string>& names() const { return names_; }
  /// Positions of those that are kept as text.
  const std::vector<std::size_t>& unknown() const { return unknown_; }

  /// Sets values and text of the row; the reason where it is a bad one.
  std::optional<BadRow> parse(std::string_view text, TraceRow& row) const;

 private:
  /// What the header says of one column.
  struct Target {
    std::size_t value = column_count;  ///< index into TraceRow::values; column_count: kept as text
    Unit unit{"", 1};
    double scale = 1;  ///< factor given with a rename
  };

  void apply_rename(const std::string& rename);
  std::string known_names() const;
  void explain(std::size_t i, const std::string& name);
  BadRow out_of_range(std::size_t i, const std::string& field) const;
  std::string wrong_count(std::string_view text) const;

  TraceOptions options_;
  std::string place_;
  std::vector<std::string> names_;
  std::vector<Target> targets_;
  std::vector<std::size_t> unknown_;
  std::array<bool, column_count> has_{};
};

}  // namespace smaservo::hal
