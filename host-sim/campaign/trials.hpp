#pragma once
// What a kind of campaign is for the engine: trials with a number, each of which gives a row.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace smaservo::campaign {

struct Column {
  std::string name;   ///< with its unit: "above_limit_K"
  bool drawn;         ///< known before the trial runs; false: its result
  bool text = false;  ///< names of classes; false: numbers
};

/// A cell of a row. NaN is an empty cell: there is no such number in this trial.
using Value = std::variant<std::uint64_t, double, std::string>;
using Row = std::vector<Value>;

/// "true" or "false", as cells say it.
std::string yes_or_no(bool value);

class Trials {
 public:
  Trials() = default;
  virtual ~Trials() = default;
  Trials(const Trials&) = delete;
  Trials& operator=(const Trials&) = delete;

  virtual const std::vector<Column>& columns() const = 0;
  /// The name of the result that the campaign is about: its greatest values are the worst.
  virtual std::string_view main_column() const = 0;
  /// Roughly the time that a trial takes on one core, from which the size of chunks is chosen.
  virtual double cost_s() const = 0;
  /// Computes a trial, which depends on nothing but the plan and its number. Several threads call
  /// this at once. As many cells as there are columns.
  virtual Row run(std::uint64_t index) const = 0;
  /// The command line that runs this trial alone, for a person to look at.
  virtual std::string command(std::uint64_t index) const = 0;
};

/// The columns `trial` and those of the kind, as the first line of a table in CSV.
std::string csv_head(const std::vector<Column>& columns);
/// One line of CSV; numbers have as many digits as it takes to read the same bits again.
std::string csv_line(std::uint64_t index, const Row& row);

}  // namespace smaservo::campaign
