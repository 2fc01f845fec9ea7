#pragma once
// The trace of a run, as `host-sim replay --device` takes it, written beside the loop.

#include <cstdint>
#include <string>

#include "firmware/daemon/loop/desk.hpp"
#include "firmware/text/device_trace.hpp"
#include "hal/linux/system/descriptor.hpp"

namespace smaservo::daemon {

/// Appends whole rows, durable once a second: a loss of power costs the last second, a full disk
/// what comes after. A cycle that is missing, because the disk was too slow for the ring, ends the
/// recording as well: what follows a gap could not be replayed. The settings at its beginning lie
/// beside it, FILE.csv.toml.
class Recorder {
 public:
  /// A file that exists is not overwritten; in a folder it is named by the time. Throws UserError.
  Recorder(const std::string& path, const Settings<double>& settings, Ring<CycleRecord>& ring,
           ParameterDesk& desk);

  /// Writes what has come since. For one thread, some times a second.
  void pump();
  /// The rest, durable.
  void finish();

  const std::string& path() const { return path_; }
  std::uint64_t rows() const { return rows_.load(std::memory_order_relaxed); }
  /// Why it has ended before its time; empty while it goes on.
  std::string problem() const;

 private:
  void add(const CycleRecord& record);
  void write();
  void make_durable();
  void end(const std::string& why);

  std::string path_;
  Ring<CycleRecord>& ring_;
  ParameterDesk& desk_;
  text::DeviceRows format_;
  hal::Descriptor file_;
  std::string buffer_;
  std::uint64_t last_ = 0;      ///< cycle
  std::int64_t written_ = 0;    ///< bytes of whole rows
  std::uint64_t buffered_ = 0;  ///< rows
  std::int64_t durable_at_ns_ = 0;
  std::atomic<std::uint64_t> rows_{0};
  mutable std::mutex problem_mutex_;
  std::string problem_;
  bool ended_ = false;
};

}  // namespace smaservo::daemon
