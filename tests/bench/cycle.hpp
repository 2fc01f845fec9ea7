#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace smaservo::benchmarks {

/// The elements of a table, one after the other, for ever.
template <class T>
class Cycle {
 public:
  explicit Cycle(std::vector<T> table) : table_(std::move(table)) {}
  std::size_t size() const { return table_.size(); }
  const T& first() const { return table_.front(); }
  const T& next() {
    const T& now = table_[at_];
    at_ = at_ + 1 == table_.size() ? 0 : at_ + 1;
    return now;
  }

 private:
  std::vector<T> table_;
  std::size_t at_ = 0;
};

}  // namespace smaservo::benchmarks
