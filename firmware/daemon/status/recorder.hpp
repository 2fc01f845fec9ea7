#pragma once
// Writes the trace of a run in parallel to the loop, for `host-sim replay-device`.

#include <cstdint>
#include <memory>
#include <string>

#include "firmware/daemon/loop/desk.hpp"
#include "firmware/text/device_trace.hpp"
#include "hal/linux/system/descriptor.hpp"
#include "hal/recording/mcap/rows_writer.hpp"

namespace smaservo::daemon {

/// Appends whole rows and makes them durable once a second: a power cut loses the last second. A
/// full disk ends the recording; so does a missing cycle, when the disk is too slow for the ring,
/// because rows after a gap could not be replayed. The settings at the beginning are in
/// FILE.csv.toml. FILE.mcap is MCAP: its rows become a chunk once a second, and its summary is
/// written at the end; a file without a summary can be read up to its end.
class Recorder {
 public:
  /// An existing file is not overwritten. If `path` is a folder, the file in it is named after the
  /// time. Throws UserError.
  Recorder(const std::string& path, const Settings<double>& settings, Ring<CycleRecord>& ring,
           ParameterDesk& desk, const std::string& board = "");

  /// Writes the rows that have come since the last call. To be called several times a second by one
  /// thread.
  void pump();
  /// Writes the remaining rows and makes them durable.
  void finish();

  const std::string& path() const { return path_; }
  /// The number of rows written.
  std::uint64_t rows() const { return rows_.load(std::memory_order_relaxed); }
  /// The reason why the recording ended early; empty while it goes on.
  std::string problem() const;

 private:
  void add(const CycleRecord& record);
  void write();
  enum class Then : unsigned char { wait, close_chunk, finish };
  bool encode(Then then);
  void write_encoded();
  void make_durable();
  void write_end();
  void end(const std::string& why);

  std::string path_;
  Ring<CycleRecord>& ring_;
  ParameterDesk& desk_;
  text::DeviceRows format_;
  std::unique_ptr<hal::mcap::RowsWriter> mcap_;
  hal::Descriptor file_;
  std::string buffer_;          ///< rows as CSV
  std::string encoded_;         ///< the rows as they are written to the file
  std::uint64_t last_ = 0;      ///< number of the last cycle
  std::int64_t written_ = 0;    ///< bytes of whole rows
  std::uint64_t buffered_ = 0;  ///< rows that have been in buffer_
  std::int64_t durable_at_ns_ = 0;
  std::atomic<std::uint64_t> rows_{0};
  mutable std::mutex problem_mutex_;
  std::string problem_;
  bool ended_ = false;
};

}  // namespace smaservo::daemon
