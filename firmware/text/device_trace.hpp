#pragma once
// The trace of a device: what went into its steps, in full precision so that it can be replayed to
// the same bits, and what came out.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/cycle.hpp"
#include "hal/recording/trace_file.hpp"

namespace smaservo::text {

/// A column: its name, and how it writes a cycle's value as text. A number is the shortest text
/// that reads back to the same bits; NaN is an empty text.
struct DeviceColumn {
  std::string_view name;
  void (*write)(std::string& to, const Cycle& cycle);
  bool is_text = false;  ///< not a number
};

/// The columns of the log: readings and command. The arguments say which of the optional readings
/// the board has.
std::vector<DeviceColumn> log_columns(bool supply, bool ambient, bool driver);
/// The columns of the step's outputs.
std::span<const DeviceColumn> output_columns();

void append_number(std::string& to, double value);

/// Writes rows of such columns as text. Further columns are given as texts, each with a comma
/// before it.
class DeviceRows {
 public:
  DeviceRows(std::vector<DeviceColumn> columns, const std::vector<std::string>& further);

  const std::string& header() const { return header_; }
  /// Of all columns but the further ones.
  std::vector<hal::mcap::Kind> kinds() const;
  void append(std::string& to, const Cycle& cycle, std::string_view further) const;

 private:
  std::vector<DeviceColumn> columns_;
  std::string header_;
};

/// Writes such rows to a file, as CSV or MCAP.
class DeviceTraceFile {
 public:
  DeviceTraceFile(const std::string& path, const hal::mcap::Origin& origin,
                  std::vector<DeviceColumn> columns, const std::vector<std::string>& further);

  void add(const Cycle& cycle, std::string_view further);
  void commit();

 private:
  DeviceRows rows_;
  hal::TraceFile file_;
  std::string buffer_;
};

}  // namespace smaservo::text
