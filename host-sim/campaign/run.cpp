#include "host-sim/campaign/run.hpp"

#include <fmt/format.h>

#include "host-sim/parallel.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::campaign {
namespace {

/// Ends the trials of a chunk.
class Stopped : public std::exception {};

class ShardRun {
 public:
  ShardRun(const Campaign& campaign, const Folder& folder, const RunOptions& options)
      : campaign_(campaign), folder_(folder), options_(options) {}

  RunResult run() {
    const std::vector<std::uint64_t> missing = missing_chunks();
    show(0);
    try {
      for (const std::uint64_t number : missing) {
        work_on(number);
      }
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

  void work_on(std::uint64_t number) {
    // Another process that divides the campaign otherwise may have made it meanwhile.
    if (folder_.chunk(campaign_, number).state == ChunkState::whole) {
      ++result_.found;
    } else {
      compute(number);
      ++result_.computed;
    }
    finished_ += size(number);
    show(0);
  }

  void compute(std::uint64_t number) const {
    const std::uint64_t first = campaign_.plan.first(number);
    std::vector<std::string> rows(static_cast<std::size_t>(size(number)));
    parallel(
        rows.size(), options_.threads,
        [&](std::size_t i) {
          if (options_.stop && options_.stop()) {
            throw Stopped();
          }
          rows[i] = csv_line(first + i, campaign_.trials->run(first + i));
        },
        [&](std::size_t done) { show(done); });
    files::OutputFile file(folder_.chunk_path(number));
    file.write(chunk_text(campaign_, number, rows));
    file.commit();
  }

  void show(std::uint64_t of_this_chunk) const {
    if (options_.progress && total_ > 0) {
      options_.progress(finished_ + of_this_chunk, total_);
    }
  }

  const Campaign& campaign_;
  const Folder& folder_;
  const RunOptions& options_;
  RunResult result_;
  std::uint64_t finished_ = 0, total_ = 0;
};

}  // namespace

RunResult run_campaign(const Campaign& campaign, const Folder& folder, const RunOptions& options) {
  const hal::Descriptor lock = folder.lock(options.shard);
  folder.remove_left_overs(options.shard);
  return ShardRun(campaign, folder, options).run();
}

}  // namespace smaservo::campaign
