#pragma once
// What a trace holds, in SI, as the checks and the identification look at it.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/replay/trace.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::checks {

/// The kind of an experiment. It follows from the columns; the first matching kind counts:
/// - calorimetry: specific power and temperature; a sample heated and cooled in a calorimeter.
/// - joule: current and voltage that heat the wire, or their power, and time. There may be a
///   temperature, but that of an infrared camera or a thermocouple on a thin wire is unreliable and
///   is not needed.
/// - imposed: the same, but a test frame or a stop sets the strain, and the load follows. No column
///   tells it from joule.
/// - settled: current and voltage that heat the wire, without time: each row is a settled state.
/// - bath: temperature, in a liquid or an oven. There may be current and voltage if they only
///   measure the resistance, with less than 0.1 W per metre: 2 K in still air, less in a bath.
enum class RunKind : unsigned char { bath, joule, settled, calorimetry, imposed };

std::string_view name_of(RunKind kind);

/// Where a quantity stands in the file.
struct Place {
  std::size_t column = 0;  ///< from 1; 0: nowhere
  std::string name;        ///< as in the file
  std::string
      unit;  ///< as the reader's own names have it: "mA"; of strain_ref, what follows "strain_"
};

/// Vectors have one element for each row, or none if the file lacks the quantity.
struct Record {
  std::string name;  ///< name of the file
  RunKind kind{};
  std::vector<double> time_s, current_A, voltage_V;
  /// From the column of the stress, otherwise from load per area.
  std::vector<double> stress_Pa;
  /// The column strain_ref. Otherwise -displacement/length, with its zero at the greatest length of
  /// the wire: such a strain is 0 or negative and does not give the absolute elongation.
  std::vector<double> strain;
  /// The column, otherwise V/I; NaN in rows where the current is below 3 % of the record's largest.
  std::vector<double> resistance_ohm;
  std::vector<double> temperature_K, ambient_K;
  std::vector<double> power_W_kg;
  std::vector<double> heating_W;  ///< the column; see heating_W_at()

  std::vector<std::uint64_t> lines;  ///< of the rows; empty: the record is from no file
  std::string line_word;             ///< what they are: "line"
  std::array<Place, hal::column_count> places;

  /// The number of rows whose electrical power is known; 0 where none is.
  std::size_t heated_rows() const {
    return heating_W.empty() ? std::min(current_A.size(), voltage_V.size()) : heating_W.size();
  }
  /// The electrical power of a row, from its column or from current and voltage, which the record
  /// must have then.
  double heating_W_at(std::size_t index) const {
    return heating_W.empty() ? current_A[index] * voltage_V[index] : heating_W[index];
  }
  /// "line 17", of a spreadsheet "row 17"; "row 12" where the record is from no file.
  std::string row(std::size_t index) const;
  /// "column 2 'I [mA]'"; `otherwise` where the record is from no file.
  std::string column(hal::Column column, std::string_view otherwise) const;
};

/// Makes a record of a trace's rows, as they are read.
class Recorder {
 public:
  static constexpr std::size_t all_rows = std::numeric_limits<std::size_t>::max();

  /// Of a trace of more rows than `most`, every second, fourth, ... block of rows is kept, so that
  /// the record is of the whole trace, and most rows still have their neighbours.
  explicit Recorder(const hal::TraceReader& trace, std::size_t most = all_rows);
  /// For rows with these columns that are from no file; `line_word` says what the numbers of rows
  /// (TraceRow::line) are.
  Recorder(std::vector<hal::Column> columns, std::string line_word, std::size_t most = all_rows);

  void add(const hal::TraceRow& row);
  std::size_t rows() const { return record_.lines.size(); }
  const std::vector<double>& of(hal::Column column) const {
    return values_[static_cast<std::size_t>(column)];
  }
  /// The record; its kind is left to its user. `name` is the file's. Once.
  Record finish(const std::string& name, const Geometry<double>& geometry);

 private:
  Record record_;
  std::array<std::vector<double>, hal::column_count> values_;
  void thin();

  static constexpr std::size_t block = 256;  ///< rows
  std::vector<hal::Column> kept_;
  std::size_t most_;
  std::size_t seen_ = 0, stride_ = 1;  ///< rows; of so many blocks one is kept
};

}  // namespace smaservo::checks
