#pragma once
// A double that counts what is computed with it, and remembers how great and how small that was.

#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace smaservo::benchmarks {

struct Operations {
  std::uint64_t additions = 0;  ///< and subtractions
  std::uint64_t multiplications = 0;
  std::uint64_t divisions = 0;
  std::uint64_t roots = 0;
  std::uint64_t comparisons = 0;
  std::uint64_t functions = 0;  ///< exp, ceil and such

  std::uint64_t all() const {
    return additions + multiplications + divisions + roots + comparisons + functions;
  }
  Operations operator-(const Operations& b) const {
    return {additions - b.additions, multiplications - b.multiplications, divisions - b.divisions,
            roots - b.roots,         comparisons - b.comparisons,         functions - b.functions};
  }
};

/// The least and the greatest magnitude, zero apart.
struct Magnitudes {
  double min = std::numeric_limits<double>::infinity();
  double max = 0;

  void add(double x) {
    const double magnitude = std::abs(x);
    if (magnitude > 0 && std::isfinite(x)) {
      min = magnitude < min ? magnitude : min;
      max = max < magnitude ? magnitude : max;
    }
  }
};

class Counted {
 public:
  Counted() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr explicit Counted(Number x) : x_(static_cast<double>(x)) {}
  constexpr explicit operator double() const { return x_; }
  constexpr explicit operator float() const { return static_cast<float>(x_); }
  constexpr explicit operator int() const { return static_cast<int>(x_); }

  static inline Operations operations;
  /// Magnitudes of the results of additions, multiplications and divisions.
  static inline Magnitudes results;

  friend Counted operator+(const Counted& a, const Counted& b) {
    return result(operations.additions, a.x_ + b.x_);
  }
  friend Counted operator-(const Counted& a, const Counted& b) {
    return result(operations.additions, a.x_ - b.x_);
  }
  friend Counted operator-(const Counted& a) { return result(operations.additions, -a.x_); }
  friend Counted operator*(const Counted& a, const Counted& b) {
    return result(operations.multiplications, a.x_ * b.x_);
  }
  friend Counted operator/(const Counted& a, const Counted& b) {
    return result(operations.divisions, a.x_ / b.x_);
  }
  Counted& operator+=(const Counted& b) { return *this = *this + b; }
  Counted& operator-=(const Counted& b) { return *this = *this - b; }
  Counted& operator*=(const Counted& b) { return *this = *this * b; }
  Counted& operator/=(const Counted& b) { return *this = *this / b; }

  friend bool operator<(const Counted& a, const Counted& b) { return compared(a.x_ < b.x_); }
  friend bool operator>(const Counted& a, const Counted& b) { return compared(a.x_ > b.x_); }
  friend bool operator<=(const Counted& a, const Counted& b) { return compared(a.x_ <= b.x_); }
  friend bool operator>=(const Counted& a, const Counted& b) { return compared(a.x_ >= b.x_); }
  friend bool operator==(const Counted& a, const Counted& b) { return compared(a.x_ == b.x_); }

  friend bool isfinite(const Counted& x) { return std::isfinite(x.x_); }
  friend Counted sqrt(const Counted& x) { return result(operations.roots, std::sqrt(x.x_)); }
  friend Counted exp(const Counted& x) { return result(operations.functions, std::exp(x.x_)); }
  friend Counted cosh(const Counted& x) { return result(operations.functions, std::cosh(x.x_)); }
  friend Counted ceil(const Counted& x) { return result(operations.functions, std::ceil(x.x_)); }
  friend Counted abs(const Counted& x) { return Counted(std::abs(x.x_)); }

 private:
  static Counted result(std::uint64_t& count, double x) {
    ++count;
    results.add(x);
    return Counted(x);
  }
  static bool compared(bool result) {
    ++operations.comparisons;
    return result;
  }

  double x_;
};

}  // namespace smaservo::benchmarks

/// As precise as a float: the refinements of the curve are those of a target.
template <>
struct std::numeric_limits<smaservo::benchmarks::Counted> : std::numeric_limits<double> {
  static constexpr int digits = std::numeric_limits<float>::digits;
  static constexpr smaservo::benchmarks::Counted quiet_NaN() noexcept {
    return smaservo::benchmarks::Counted(std::numeric_limits<double>::quiet_NaN());
  }
};
