#include "firmware/daemon/status/status_writer.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "firmware/daemon/status/recorder.hpp"
#include "firmware/safety/faults/table.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {

StatusWriter::StatusWriter(std::string file, std::string board, std::int64_t period_ns,
                           const StatusSources& sources)
    : file_(std::move(file)), board_(std::move(board)), period_ns_(period_ns), from_(sources) {}

void StatusWriter::warn(const std::string& text) {
  warnings_.push_back(text);
  files::complain("smaservod", text);
}

void StatusWriter::look() {
  from_.links.output.take(output_);
  for_each_fault(output_.latched - logged_, [&](Fault fault) {
    files::complain("smaservod",
                    fmt::format("{:.3f} s: {}: {}", static_cast<double>(output_.time_us) * 1e-6,
                                fault_name(fault), fault_row(fault).text));
  });
  logged_ = output_.latched;
  WarningCounts causes{};
  std::ranges::transform(from_.figures.warning_causes, causes.begin(),
                         [](const auto& count) { return count.load(std::memory_order_relaxed); });
  for (const std::string& line : journal_.lines(output_.time_us, causes)) {
    files::complain("smaservod", line);
  }
  from_.usage.look(from_.figures.cycles.load());
}

Status StatusWriter::status(bool runs) const {
  Status now{.board = board_,
             .period_ns = period_ns_,
             .figures = from_.figures,
             .output = output_,
             .usage = from_.usage.taken(from_.figures.cycles.load(), runs),
             .recording = {},
             .last_run = from_.mark ? describe(from_.mark->last()) : "",
             .warnings = warnings_};
  if (const auto& recorder = from_.recorder) {
    now.recording = {recorder->path(), recorder->rows(), recorder->problem()};
  }
  return now;
}

void StatusWriter::write(bool runs) {
  if (file_.empty() || fails_) {
    return;
  }
  try {
    files::OutputFile file(file_);
    file.write(status_json(status(runs)));
    file.commit();
  } catch (const files::UserError& error) {
    fails_ = true;
    warn(error.what());
  }
}

}  // namespace smaservo::daemon
