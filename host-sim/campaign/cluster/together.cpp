#include "host-sim/campaign/cluster/together.hpp"

#include <atomic>
#include <chrono>
#include <fmt/format.h>
#include <mutex>
#include <thread>

#include "host-sim/end_by_signal.hpp"
#include "model/files/message.hpp"

namespace smaservo::campaign {
namespace {

/// A rank that waits looks after the others so often, and takes next to nothing of its processor.
constexpr std::chrono::milliseconds between_looks_of_waiting{2};
/// One that works looks between two trials; not more often than this.
constexpr std::chrono::milliseconds between_looks_at_work{10};

/// A text of this rank for a person.
std::string marked(const Ranks& ranks, const std::string& text) {
  return ranks.rank() == 0 ? text
                           : fmt::format("rank {} of {}: {}", ranks.rank(), ranks.count(), text);
}

/// Waits, but not longer than this rank may live.
void pause() {
  if (EndBySignal::came()) {
    throw EndedBySignal();
  }
  std::this_thread::sleep_for(between_looks_of_waiting);
}

/// The greatest of a number of all ranks. Waits for them.
std::uint64_t greatest(Ranks& ranks, std::uint64_t own) {
  for (;;) {
    if (const auto all = ranks.combine({own}, Ranks::How::greatest)) {
      return all->front();
    }
    pause();
  }
}

/// The work of one rank, which again and again adds up with the others how far each is.
class SharedRun {
 public:
  SharedRun(Ranks& ranks, const RunOptions& options) : ranks_(ranks), options_(options) {}

  RunResult run(const Campaign& campaign, const Folder& folder) {
    std::exception_ptr error;
    RunResult result;
    try {
      result = run_campaign(campaign, folder, options_of_this_rank());
    } catch (...) {
      error = std::current_exception();
    }
    if (result.stopped && !another_failed_) {
      throw EndedBySignal();
    }
    {
      const std::scoped_lock lock(mutex_);
      own_[begun] = own_[ended] = 1;
      own_[failed] = error ? 1 : 0;
      own_[chunks] = result.chunks;
      own_[found] = result.found;
      own_[computed] = result.computed;
    }
    while (!all_have_ended()) {
      pause();
    }
    if (error) {
      std::rethrow_exception(error);
    }
    return {all_[chunks], all_[found], all_[computed], false};
  }

 private:
  enum Place : std::uint8_t { done, total, begun, ended, failed, chunks, found, computed };

  RunOptions options_of_this_rank() {
    RunOptions options = options_;
    options.shard = {ranks_.rank(), ranks_.count()};
    options.progress = [this](std::uint64_t now, std::uint64_t whole) {
      const std::scoped_lock lock(mutex_);
      own_[done] = now;
      own_[total] = whole;
      own_[begun] = 1;
    };
    options.stop = [this] { return ends(); };
    options.warn = [this](const std::string& text) {
      if (options_.warn) {
        options_.warn(marked(ranks_, text));
      }
    };
    return options;
  }

  /// Between two trials, in several threads.
  bool ends() {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    const auto now = std::chrono::steady_clock::now();
    if (lock && now >= next_look_) {
      next_look_ = now + between_looks_at_work;
      look();
    }
    return another_failed_ || (options_.stop && options_.stop());
  }

  bool all_have_ended() {
    const std::scoped_lock lock(mutex_);
    look();
    return all_[ended] == ranks_.count();
  }

  void look() {
    const auto sums = ranks_.combine(own_, Ranks::How::sum);
    if (!sums) {
      return;
    }
    all_ = *sums;
    another_failed_ = all_[failed] > 0;
    if (ranks_.rank() == 0 && options_.progress && all_[begun] == ranks_.count() &&
        all_[total] > 0) {
      options_.progress(all_[done], all_[total]);
    }
  }

  Ranks& ranks_;
  const RunOptions& options_;
  std::mutex mutex_;  // of all below
  Ranks::Numbers own_{}, all_{};
  std::chrono::steady_clock::time_point next_look_;
  std::atomic<bool> another_failed_ = false;
};

}  // namespace

void all_do(Ranks& ranks, const std::function<void()>& work) {
  std::string error;
  std::uint64_t place = 0;  // greater in the first ranks; 0: without an error
  try {
    work();
  } catch (const EndedBySignal&) {
    throw;
  } catch (const std::exception& e) {
    error = e.what();
    place = ranks.count() - ranks.rank();
  }
  const std::uint64_t first = greatest(ranks, place);
  if (first == 0) {
    return;
  }
  if (first == place) {
    files::complain("host-sim", marked(ranks, error));
  }
  // What has started them ends all ranks when the first one ends: not before the error is printed.
  greatest(ranks, 0);
  throw EndedTogether();
}

RunResult run_together(Ranks& ranks, const Campaign& campaign, const Folder& folder,
                       const RunOptions& options) {
  return SharedRun(ranks, options).run(campaign, folder);
}

}  // namespace smaservo::campaign
