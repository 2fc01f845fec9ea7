#pragma once

#include <cstdint>
#include <string>

namespace smaservo::bench {

/// A line on the terminal that shows the progress of a long job; silent if standard error is no
/// terminal.
class Progress {
 public:
  /// `total` 0: the amount of work is not known.
  Progress(std::string what, std::uint64_t total);
  ~Progress();  ///< clears the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap: looks at the clock at every 4096th call only.
  void update(std::uint64_t done);
  /// Looks at the clock every time: for few, long parts.
  void step(std::uint64_t done);

 private:
  void print(std::uint64_t done);

  std::string what_;
  std::uint64_t total_;
  bool terminal_;
  bool printed_ = false;
  std::uint32_t calls_ = 0;
  std::int64_t start_ns_ = 0;
  std::int64_t next_ns_ = 0;
};

}  // namespace smaservo::bench
