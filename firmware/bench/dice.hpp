#pragma once
// Random numbers of a unit or a run, all from one seed.

#include <algorithm>
#include <cstdint>
#include <random>

namespace smaservo::bench {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  /// Normally distributed, cut at 2.5 standard deviations.
  double deviation(double sd) { return sd * std::clamp(normal_(random_), -2.5, 2.5); }
  double factor(double sd) { return 1 + deviation(sd); }
  bool coin() { return uniform(0, 1) < 0.5; }
  std::uint64_t seed() { return random_(); }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace smaservo::bench
