#include "hal/recording/trace_file.hpp"

#include <fmt/format.h>

#include "model/files/error.hpp"

namespace smaservo::hal {

bool is_mcap_name(std::string_view path) {
  return path.ends_with(".mcap");
}

TraceFile::TraceFile(const std::string& path, const mcap::Origin& origin,
                     std::vector<mcap::Kind> kinds)
    : path_(path), file_(path) {
  if (is_mcap_name(path)) {
    mcap_.emplace(origin, std::move(kinds));
  }
}

void TraceFile::write(std::string_view csv) {
  if (!mcap_) {
    file_.write(csv);
    return;
  }
  try {
    mcap_->add(csv);
  } catch (const files::UserError& problem) {
    throw files::UserError(fmt::format("{}: {}", path_, problem.what()));
  }
  file_.write(mcap_->take());
}

void TraceFile::commit() {
  if (mcap_) {
    try {
      mcap_->finish();
    } catch (const files::UserError& problem) {
      throw files::UserError(fmt::format("{}: {}", path_, problem.what()));
    }
    file_.write(mcap_->take());
  }
  file_.commit();
}

}  // namespace smaservo::hal
