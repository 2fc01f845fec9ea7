#pragma once
// Computes the chunks of a campaign that are missing.

#include <functional>
#include <string>

#include "host-sim/campaign/folder.hpp"

namespace smaservo::campaign {

struct RunOptions {
  Shard shard;
  int threads = 1;  ///< does not affect the result
  /// Number of finished trials, and of all that are to be computed; not called if there are none.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;
  /// Asked before each trial, and by long ones; true ends the work.
  Stop stop;
  /// Is told of chunks that are computed again because they are broken.
  std::function<void(const std::string&)> warn;
};

struct RunResult {
  std::uint64_t chunks = 0;    ///< of the shard
  std::uint64_t found = 0;     ///< that were there
  std::uint64_t computed = 0;  ///< by this run
  bool stopped = false;

  bool whole() const { return found + computed == chunks; }
};

/// Computes all chunks of the shard that are missing or broken, each of which is written when it is
/// whole; when this stops or throws, they are kept, and the chunks in work are lost: one, or as
/// many as there are threads if a chunk has fewer trials than that. Throws UserError, and what
/// trials throw.
RunResult run_campaign(const Campaign& campaign, const Folder& folder, const RunOptions& options);

}  // namespace smaservo::campaign
