#include "host-sim/page/servos/messages/exports.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <vector>

#include "hal/recording/mcap/rows_writer.hpp"
#include "host-sim/page/servos/messages/requests.hpp"
#include "host-sim/page/servos/messages/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

using files::UserError;
using nlohmann::json;

constexpr std::size_t max_kept = 8;

std::string to_mcap(const can::Recording& recording) {
  namespace mcap = hal::mcap;
  mcap::RowsWriter rows({"host-sim page", "recording"},
                        std::vector(1 + recording.signals.size(), mcap::Kind::number));
  rows.add(can::to_csv(recording));
  rows.finish();
  return rows.take();
}

/// A format in which a recording can be exported; another format is another row.
struct Export {
  const char* as;
  const char* file;
  std::string (*bytes)(const can::Recording& recording);
};
constexpr auto exports = std::to_array<Export>({
    {"csv", "recording.csv", can::to_csv},
    {"mcap", "recording.mcap", to_mcap},
});

}  // namespace

std::string base64(const std::string& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      three = three << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : digits[three >> (18U - 6 * k) & 63U];
    }
  }
  return text;
}

json KeptRecordings::kept(const can::Recording& recording, const json& gains) {
  json message = recording_message(recording);
  const std::scoped_lock lock(mutex_);
  recordings_.emplace_back(++count_, recording);
  can::Recording& file = recordings_.back().second;
  file.period_s = message["period_s"].get<double>();
  for (const auto& [name, value] : gains.items()) {
    if (value.is_number()) {
      file.signals.push_back(name);
      for (std::vector<double>& row : file.rows) {
        row.push_back(value.get<double>());
      }
    }
  }
  if (recordings_.size() > max_kept) {
    recordings_.pop_front();
  }
  message["id"] = count_;
  return message;
}

can::Recording KeptRecordings::asked_for(const json& request) {
  const auto given = request.find("recording");
  if (given == request.end() || !given->is_number_unsigned()) {
    return recording_of(given == request.end() ? json() : *given);
  }
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find_if(recordings_, [&](const auto& kept_one) {
    return kept_one.first == given->get<std::uint64_t>();
  });
  if (found == recordings_.end()) {
    throw UserError(fmt::format("recording {}: is not kept any more; only the last {} are",
                                json_text(*given), max_kept));
  }
  return found->second;
}

json KeptRecordings::exported(const json& request) {
  const std::string as = text_in(request, "as");
  const auto* const row = std::ranges::find(exports, as, &Export::as);
  if (row == exports.end()) {
    std::vector<std::string> known;
    known.reserve(exports.size());
    for (const Export& other : exports) {
      known.emplace_back(other.as);
    }
    throw UserError(
        fmt::format("as = {}: must be {}", files::printable(as), fmt::join(known, " or ")));
  }
  return {{"name", row->file}, {"base64", base64(row->bytes(asked_for(request)))}};
}

}  // namespace smaservo::page
