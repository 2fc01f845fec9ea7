#pragma once
// The scalar type for the derivatives of the fit: a number with its derivatives by some parameters
// (forward automatic differentiation). Ceres has such a type, too, whose derivatives are an Eigen
// vector. With it the fit takes twice as long, since GCC 12 compiles each operation as a call.

#include <cmath>
#include <limits>

namespace smaservo::identify {

/// Number of parameters whose derivatives are computed at once.
inline constexpr int jet_width = 15;
/// The index of one more derivative: that by the temperature at the end of a step.
inline constexpr int jet_temperature = jet_width;

/// The values are those of double, to the bit: a path through the hysteresis reverses where a
/// comparison decides so, and must be the same with and without derivatives.
struct Jet {
  static constexpr int size = jet_width + 1;

  double a = 0;
  alignas(32) double v[size]{};

  Jet() = default;
  explicit Jet(double value) : a(value) {}
  /// The parameter with this index.
  Jet(double value, int index) : a(value) { v[index] = 1; }

  /// A function of f with this value and this derivative by f.
  Jet(double value, double slope, const Jet& f) : a(value) {
    for (int i = 0; i < size; ++i) {
      v[i] = slope * f.v[i];
    }
  }

  [[gnu::always_inline]] friend Jet operator+(const Jet& f, const Jet& g) {
    Jet sum(f.a + g.a);
    for (int i = 0; i < size; ++i) {
      sum.v[i] = f.v[i] + g.v[i];
    }
    return sum;
  }
  [[gnu::always_inline]] friend Jet operator-(const Jet& f, const Jet& g) {
    Jet difference(f.a - g.a);
    for (int i = 0; i < size; ++i) {
      difference.v[i] = f.v[i] - g.v[i];
    }
    return difference;
  }
  [[gnu::always_inline]] friend Jet operator*(const Jet& f, const Jet& g) {
    Jet product(f.a * g.a);
    for (int i = 0; i < size; ++i) {
      product.v[i] = f.a * g.v[i] + f.v[i] * g.a;
    }
    return product;
  }
  [[gnu::always_inline]] friend Jet operator/(const Jet& f, const Jet& g) {
    Jet quotient(f.a / g.a);
    const double reciprocal = 1 / g.a;
    for (int i = 0; i < size; ++i) {
      quotient.v[i] = (f.v[i] - quotient.a * g.v[i]) * reciprocal;
    }
    return quotient;
  }
  friend Jet operator-(const Jet& f) { return {-f.a, -1, f}; }
  Jet& operator+=(const Jet& g) { return *this = *this + g; }
  Jet& operator-=(const Jet& g) { return *this = *this - g; }
  Jet& operator*=(const Jet& g) { return *this = *this * g; }
  Jet& operator/=(const Jet& g) { return *this = *this / g; }

  friend bool operator<(const Jet& f, const Jet& g) { return f.a < g.a; }

  friend Jet sqrt(const Jet& f) {
    const double root = std::sqrt(f.a);
    return {root, 1 / (2 * root), f};
  }
  friend Jet exp(const Jet& f) {
    const double value = std::exp(f.a);
    return {value, value, f};
  }
};

}  // namespace smaservo::identify

template <>
struct std::numeric_limits<smaservo::identify::Jet> : std::numeric_limits<double> {};
