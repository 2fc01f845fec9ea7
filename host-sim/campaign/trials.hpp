#pragma once
// What a kind of campaign is for the engine: trials with a number, each of which gives a row.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace smaservo::campaign {

struct Column {
  std::string name;   ///< with its unit: "above_limit_K"
  bool drawn;         ///< known before the trial runs; false: its result
  bool text = false;  ///< names of classes; false: numbers
  /// For those who read the table: what is printed has no statistics of it.
  bool quiet = false;
};

/// A cell of a row. NaN is an empty cell: there is no such number in this trial.
using Value = std::variant<std::uint64_t, double, std::string>;
using Row = std::vector<Value>;

/// A file that a trial leaves besides its row, such as a calibrated wire. Names are those of no
/// other trial of the campaign, without folders.
struct TrialFile {
  std::string name;
  std::string text;
};

struct TrialResult {
  Row row;
  std::vector<TrialFile> files = {};  // NOLINT(readability-redundant-member-init): for braces
};

/// Is asked by long trials whether to end; they then throw Stopped.
using Stop = std::function<bool()>;
class Stopped : public std::exception {};

/// "true" or "false", as cells say it.
std::string yes_or_no(bool value);

/// What README files say of trials of a kind.
class Table {
 public:
  Table() = default;
  virtual ~Table() = default;
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  /// The cells of the next trial, without its number.
  virtual void add(const std::vector<std::string>& cells) = 0;
  /// A file that a trial has left.
  virtual void add(const TrialFile& file) = 0;
  /// For a terminal; empty if what is printed of every campaign says it.
  virtual std::string text() const = 0;
  virtual std::string markdown() const = 0;
  /// Marks the table in a Markdown file (evaluate::TableFile).
  virtual std::string_view mark() const = 0;
};

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
  virtual TrialResult run(std::uint64_t index, const Stop& stop) const = 0;
  /// The command line that runs this trial alone, for a person to look at.
  virtual std::string command(std::uint64_t index) const = 0;
  /// A table without trials; none if the kind has no such table.
  virtual std::unique_ptr<Table> table() const { return nullptr; }
};

/// A row for a person: a line with name and value for each cell that is not empty.
std::string row_text(const std::vector<Column>& columns, const Row& row);

/// The columns `trial` and those of the kind, as the first line of a table in CSV.
std::string csv_head(const std::vector<Column>& columns);
/// One line of CSV; numbers have as many digits as it takes to read the same bits again.
std::string csv_line(std::uint64_t index, const Row& row);

}  // namespace smaservo::campaign
