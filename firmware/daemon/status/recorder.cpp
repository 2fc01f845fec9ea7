#include "firmware/daemon/status/recorder.hpp"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include "firmware/text/settings_file.hpp"
#include "hal/linux/system/clock.hpp"
#include "hal/recording/trace_file.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

constexpr std::int64_t durable_every_ns = 1'000'000'000;

std::vector<text::DeviceColumn> columns() {
  std::vector<text::DeviceColumn> all = text::log_columns(true, true, true);
  all.insert(all.end(), text::output_columns().begin(), text::output_columns().end());
  return all;
}

std::string file_for(const std::string& path) {
  return std::filesystem::is_directory(path)
             ? fmt::format("{}/smaservo-{:%Y%m%dT%H%M%SZ}-{}.csv", path,
                           fmt::gmtime(std::time(nullptr)), getpid())
             : path;
}

}  // namespace

Recorder::Recorder(const std::string& path, const Settings<double>& settings,
                   Ring<CycleRecord>& ring, ParameterDesk& desk, const std::string& board)
    : path_(file_for(path)),
      ring_(ring),
      desk_(desk),
      format_(columns(), {"parameter_changes"}),
      file_(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)),
      buffer_(format_.header()) {
  if (file_.number() < 0 && errno == EEXIST) {
    throw files::ConfigError(
        fmt::format("--record {}: exists; a recording is never overwritten", path_));
  }
  if (file_.number() < 0) {
    throw files::UserError(fmt::format("--record {}: {}", path_, std::strerror(errno)));
  }
  if (hal::is_mcap_name(path_)) {
    std::vector<hal::mcap::Kind> kinds = format_.kinds();
    kinds.push_back(hal::mcap::Kind::text);  // parameter_changes
    mcap_ = std::make_unique<hal::mcap::RowsWriter>(hal::mcap::Origin{"smaservod --record", board},
                                                    std::move(kinds));
  }
  files::OutputFile beside(path_ + ".toml");
  beside.write(text::to_toml(settings));
  beside.commit();
  write();
  make_durable();
  if (ended_) {
    throw files::UserError(fmt::format("--record {}: {}", path_, problem_));
  }
}

void Recorder::pump() {
  CycleRecord record{};
  while (ring_.pop(record)) {
    add(record);
  }
  write();
  if (!ended_ && hal::monotonic_ns() - durable_at_ns_ >= durable_every_ns) {
    make_durable();
  }
}

void Recorder::finish() {
  pump();
  if (!ended_) {
    make_durable();
  }
  write_end();
}

std::string Recorder::problem() const {
  const std::scoped_lock lock(problem_mutex_);
  return problem_;
}

void Recorder::add(const CycleRecord& record) {
  if (ended_) {
    return;
  }
  if (record.number != last_ + 1) {
    write();
    write_end();
    end(fmt::format("the disk was too slow: {} cycles are missing", record.number - last_ - 1));
    return;
  }
  last_ = record.number;
  const std::string changes = record.set == 0 ? "" : desk_.take_text(record.set);
  format_.append(buffer_, record.cycle, "," + changes);
  ++buffered_;
  if (buffer_.size() > (std::size_t{1} << 16U)) {
    write();
  }
}

/// Writes the rows to the file; rows of an MCAP file may have to wait for their chunk.
void Recorder::write() {
  if (ended_) {
    buffer_.clear();
    return;
  }
  if (mcap_) {
    if (encode(Then::wait)) {
      write_encoded();
    }
  } else {
    encoded_.swap(buffer_);
    write_encoded();
  }
  buffer_.clear();
}

/// Converts the rows to MCAP; false if that fails, which ends the recording.
bool Recorder::encode(Then then) {
  try {
    mcap_->add(buffer_);
    buffer_.clear();
    if (then == Then::close_chunk) {
      mcap_->flush();
    } else if (then == Then::finish) {
      mcap_->finish();
    }
    encoded_ = mcap_->take();
    return true;
  } catch (const files::UserError& error) {
    end(error.what());
    return false;
  }
}

void Recorder::write_encoded() {
  std::size_t done = 0;
  while (!ended_ && done < encoded_.size()) {
    const ssize_t n = ::write(file_.number(), encoded_.data() + done, encoded_.size() - done);
    if (n < 0 && errno == EINTR) {
      continue;
    }
    if (n <= 0) {
      end(std::strerror(errno));
      break;
    }
    done += static_cast<std::size_t>(n);
  }
  if (!ended_) {
    written_ += static_cast<std::int64_t>(encoded_.size());
    rows_.store(mcap_ ? mcap_->closed() : buffered_, std::memory_order_relaxed);
  }
  encoded_.clear();
}

/// Writes the part of an MCAP file that follows its rows.
void Recorder::write_end() {
  if (mcap_ && !ended_ && encode(Then::finish)) {
    write_encoded();
    mcap_.reset();
    make_durable();
  }
}

void Recorder::make_durable() {
  durable_at_ns_ = hal::monotonic_ns();
  if (mcap_ && !ended_ && encode(Then::close_chunk)) {
    write_encoded();
  }
  if (ended_) {
    return;
  }
  // EINVAL: the file is a pipe or a device.
  if (fdatasync(file_.number()) != 0 && errno != EINVAL) {
    end(std::strerror(errno));
  }
}

/// Ends the recording and cuts off a partly written row.
void Recorder::end(const std::string& why) {
  ended_ = true;
  const bool whole = ftruncate(file_.number(), written_) == 0 && fdatasync(file_.number()) == 0;
  const std::scoped_lock lock(problem_mutex_);
  problem_ = whole ? why : why + "; its last row may be cut off";
}

}  // namespace smaservo::daemon
