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
                   Ring<CycleRecord>& ring, ParameterDesk& desk)
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

void Recorder::write() {
  std::size_t done = 0;
  while (!ended_ && done < buffer_.size()) {
    const ssize_t n = ::write(file_.number(), buffer_.data() + done, buffer_.size() - done);
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
    written_ += static_cast<std::int64_t>(buffer_.size());
    rows_.fetch_add(buffered_, std::memory_order_relaxed);
  }
  buffer_.clear();
  buffered_ = 0;
}

void Recorder::make_durable() {
  durable_at_ns_ = hal::monotonic_ns();
  if (fdatasync(file_.number()) != 0 && errno != EINVAL) {  // EINVAL: it is a pipe or a device
    end(std::strerror(errno));
  }
}

/// Ends the recording and cuts off a row that was written in part.
void Recorder::end(const std::string& why) {
  ended_ = true;
  const bool whole = ftruncate(file_.number(), written_) == 0 && fdatasync(file_.number()) == 0;
  const std::scoped_lock lock(problem_mutex_);
  problem_ = whole ? why : why + "; its last row may be cut off";
}

}  // namespace smaservo::daemon
