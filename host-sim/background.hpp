#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace smaservo {

/// Runs tasks one after the other in a thread of its own, which begins with the first one. A task
/// must not throw. run() and ended() may be called from any thread, finish() from the owner's.
class Background {
 public:
  /// Tasks that may wait while one runs.
  static constexpr std::size_t most_waiting = 8;

  Background() = default;
  ~Background() { finish(); }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  /// Returns false if too many tasks wait already, or after finish(): the task is not run then.
  bool run(std::function<void()> task) {
    const std::scoped_lock lock(mutex_);
    if (ended_ || waiting_.size() >= most_waiting) {
      return false;
    }
    waiting_.push_back(std::move(task));
    if (!thread_.joinable()) {
      thread_ = std::thread([this] { work(); });
    }
    some_.notify_one();
    return true;
  }

  /// Whether finish() was called: a task that takes long asks from time to time, and returns.
  bool ended() const { return ended_; }

  /// Waits for the task that runs. Those that wait are dropped, and whoever waits for them gets no
  /// answer.
  void finish() {
    {
      const std::scoped_lock lock(mutex_);
      ended_ = true;
      waiting_.clear();
      some_.notify_one();
    }
    if (thread_.joinable()) {
      thread_.join();
    }
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      some_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
      if (ended_) {
        return;
      }
      const std::function<void()> task = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      task();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable some_;
  std::deque<std::function<void()>> waiting_;
  std::atomic<bool> ended_ = false;  ///< changes under mutex_
  std::thread thread_;
};

}  // namespace smaservo
