#pragma once
// The columns of a trace: parses its header and the values of its rows.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/sheet/meaning.hpp"
#include "hal/replay/trace.hpp"
#include "model/units.hpp"

namespace smaservo::hal {

/// The reason why a row is bad.
struct BadRow {
  std::size_t column;
  std::string reason;
};

/// The name of a column in SI, as "current_A".
std::string si_name(Column column);

class TraceColumns {
 public:
  /// `place` names the header in messages. In a table of another program (`foreign`), a name of
  /// this reader without a unit is a hint and no error. Throws UserError, which does not name the
  /// file.
  TraceColumns(std::string_view header, const TraceOptions& options, std::string place,
               bool foreign = false);

  /// Whether the line has a column's name and unit as this reader writes them, and time, current,
  /// voltage and load under no name of another program.
  static bool is_own_header(std::string_view line);

  bool has(Column column) const { return has_[static_cast<std::size_t>(column)]; }
  /// The position of this column, which the file must have.
  std::size_t position(Column column) const;
  const std::vector<std::string>& names() const { return names_; }
  /// The positions of the columns that are kept as text.
  const std::vector<std::size_t>& unknown() const { return unknown_; }

  /// The columns whose meaning was found by other names: "current = column 3 'I [mA]' in mA; ...";
  /// empty: there are none.
  const std::string& recognised() const { return recognised_; }
  /// The name of a column in this project's dialect, "current_mA" for 'I [mA]', and the factor that
  /// its numbers then need; the file's own name where it is not understood.
  std::string own_name(std::size_t i) const;
  double scale(std::size_t i) const { return targets_[i].scale; }
  /// The unit of own_name() of this column, which the file must have.
  const Unit& unit(Column column) const { return targets_[position(column)].unit; }
  /// What columns may mean that were not taken, and what to type: one sentence each.
  const std::vector<std::string>& hints() const { return hints_; }

  /// Sets the row's values and text; returns the reason if the row is bad.
  std::optional<BadRow> parse(std::string_view text, TraceRow& row) const;
  /// The same for a row that is numbers already, one for each column; the row gets no text.
  std::optional<BadRow> take_numbers(std::span<const double> numbers, TraceRow& row) const;

 private:
  /// How one column is interpreted, as the header says.
  struct Target {
    std::size_t value = column_count;  ///< index into TraceRow::values; column_count: kept as text
    Unit unit{"", 1};
    double scale = 1;  ///< factor given together with a rename
  };

  void apply_rename(const std::string& rename);
  std::string known_names() const;
  void explain(std::size_t i, const std::string& name);
  void recognise();
  void take_resistance();
  void leave_power();
  void take(std::size_t i, const Meaning& meaning);
  void hint(std::size_t i, const Meaning& meaning, bool one_of_several);
  std::optional<std::size_t> find_column(const std::string& column) const;
  bool apply_unit(const std::string& rename, const std::string& name, const std::string& column);
  void derive_voltage(TraceRow& row) const;
  BadRow out_of_range(std::size_t i, const std::string& field) const;
  std::string wrong_count(std::string_view text) const;

  TraceOptions options_;
  std::string place_;
  bool foreign_;
  std::vector<std::string> names_;
  std::vector<Target> targets_;
  std::vector<std::size_t> unknown_;
  std::array<bool, column_count> has_{};
  bool voltage_of_resistance_ = false;
  std::string recognised_;
  std::vector<std::string> hints_;
};

}  // namespace smaservo::hal
