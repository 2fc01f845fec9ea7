#include "host-sim/campaign/run.hpp"

#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "host-sim/parallel.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::campaign {
namespace {

class ShardRun {
 public:
  ShardRun(const Campaign& campaign, const Folder& folder, const RunOptions& options)
      : campaign_(campaign), folder_(folder), options_(options) {}

  RunResult run() {
    const std::vector<std::uint64_t> missing = missing_chunks();
    open_.resize(missing.size());
    show(0);
    try {
      // Threads take trials over all chunks, so that none of them waits at the end of a chunk. Only
      // the last chunk of the campaign may have fewer trials than the others.
      parallel(
          static_cast<std::size_t>(total_), options_.threads,
          [&](std::size_t i) {
            const std::size_t at = i / static_cast<std::size_t>(campaign_.plan.chunk);
            work_on(missing[at], open_[at], i % static_cast<std::size_t>(campaign_.plan.chunk));
          },
          [&](std::size_t done) { show(done); });
    } catch (const Stopped&) {
      result_.stopped = true;
    }
    return result_;
  }

 private:
  std::uint64_t size(std::uint64_t number) const {
    return campaign_.plan.first(number + 1) - campaign_.plan.first(number);
  }

  /// Whether a chunk is there. Throws UserError if it is of another plan.
  bool is_there(std::uint64_t number) const {
    const ChunkFile file = folder_.chunk(campaign_, number);
    const std::string problem = fmt::format("{}: {}", folder_.chunk_path(number), file.problem);
    if (file.state == ChunkState::foreign) {
      throw files::UserError(problem + "; remove it, or choose another folder for --out");
    }
    if (file.state == ChunkState::broken && options_.warn) {
      options_.warn(problem + "; it is computed again");
    }
    return file.state == ChunkState::whole;
  }

  std::vector<std::uint64_t> missing_chunks() {
    std::vector<std::uint64_t> missing;
    const std::uint64_t all = campaign_.plan.chunks();
    for (std::uint64_t i = options_.shard.index; i < all; i += options_.shard.count) {
      ++result_.chunks;
      if (is_there(i)) {
        ++result_.found;
      } else {
        missing.push_back(i);
        total_ += size(i);
      }
    }
    return missing;
  }

  /// A chunk in work.
  struct Open {
    bool begun = false;
    std::unique_ptr<std::vector<TrialResult>> results;  ///< none if it is not computed
    std::uint64_t left = 0;                             ///< trials that have not ended
  };

  void work_on(std::uint64_t number, Open& chunk, std::size_t trial) {
    if (options_.stop && options_.stop()) {
      throw Stopped();
    }
    if (!begin(number, chunk)) {
      return;
    }
    TrialResult result = campaign_.trials->run(campaign_.plan.first(number) + trial, options_.stop);
    std::unique_ptr<std::vector<TrialResult>> all;
    {
      const std::scoped_lock lock(mutex_);
      (*chunk.results)[trial] = std::move(result);
      if (--chunk.left > 0) {
        return;
      }
      all = std::move(chunk.results);
    }
    files::OutputFile file(folder_.chunk_path(number));
    file.write(chunk_text(campaign_, number, *all));
    file.commit();
    const std::scoped_lock lock(mutex_);
    ++result_.computed;
  }

  /// Before the first trial of a chunk. False if its trials are not to be computed, since another
  /// process that divides the campaign otherwise has made it meanwhile.
  bool begin(std::uint64_t number, Open& chunk) {
    const std::scoped_lock lock(mutex_);
    if (!chunk.begun) {
      chunk.begun = true;
      chunk.left = size(number);
      if (folder_.chunk(campaign_, number).state == ChunkState::whole) {
        ++result_.found;
      } else {
        chunk.results =
            std::make_unique<std::vector<TrialResult>>(static_cast<std::size_t>(chunk.left));
      }
    }
    return chunk.results != nullptr;
  }

  void show(std::uint64_t done) const {
    if (options_.progress && total_ > 0) {
      options_.progress(done, total_);
    }
  }

  const Campaign& campaign_;
  const Folder& folder_;
  const RunOptions& options_;
  RunResult result_;
  std::mutex mutex_;  ///< of open_ and result_
  std::vector<Open> open_;
  std::uint64_t total_ = 0;  ///< trials to be computed
};

}  // namespace

RunResult run_campaign(const Campaign& campaign, const Folder& folder, const RunOptions& options) {
  const hal::Descriptor lock = folder.lock(options.shard);
  folder.remove_left_overs(options.shard);
  return ShardRun(campaign, folder, options).run();
}

}  // namespace smaservo::campaign
