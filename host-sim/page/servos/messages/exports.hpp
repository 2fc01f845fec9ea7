#pragma once
// Exports recordings as files.

#include <deque>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>

#include "host-sim/can/bus/recording.hpp"

namespace smaservo::page {

/// The bytes in base64 (RFC 4648).
std::string base64(const std::string& bytes);

/// The last recordings. All functions may be called from any thread.
class KeptRecordings {
 public:
  /// Keeps a recording and returns its message, by whose `id` it can be exported: the whole
  /// recording may be too long for a request. A file of it has a column for each of `gains`
  /// (parameters by name) that is a number.
  nlohmann::json kept(const can::Recording& recording, const nlohmann::json& gains);
  /// The answer to the service `export`. Throws UserError.
  nlohmann::json exported(const nlohmann::json& request);

 private:
  can::Recording asked_for(const nlohmann::json& request);

  std::mutex mutex_;
  std::deque<std::pair<unsigned, can::Recording>> recordings_;
  unsigned count_ = 0;
};

}  // namespace smaservo::page
