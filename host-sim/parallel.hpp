#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

namespace smaservo {

/// Calls part(i) for all i below count, in order but by several threads at once. After each part
/// `done` is called with the number of finished parts, never by two threads at once. If parts or
/// `done` after them throw, rethrows the exception of the part with the lowest number; later parts
/// may not have begun then.
template <class Part>
void parallel(std::size_t count, int threads, const Part& part,
              const std::function<void(std::size_t)>& done) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::size_t finished = 0;
  std::size_t failed = std::numeric_limits<std::size_t>::max();
  std::exception_ptr error;
  const auto keep = [&](std::size_t i) {
    error = i < failed ? std::current_exception() : error;
    failed = std::min(failed, i);
    next = count;
  };
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        part(i);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        keep(i);
      }
      const std::scoped_lock lock(mutex);
      try {
        done(++finished);
      } catch (...) {
        keep(i);
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (int i = 1; i < threads; ++i) {
      others.emplace_back(work);
    }
    work();
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

}  // namespace smaservo
