#pragma once
// Two numbers computed side by side: a scalar type for the model's templates that evaluates two
// transformation curves for the price of one on machines with vector registers.

#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>
#include <utility>

namespace smaservo {

/// The lane-wise choice between two values; here for plain scalars, below for pairs.
template <class S>
constexpr S select(bool condition, const S& yes, const S& no) {
  return condition ? yes : no;
}

/// Whether a comparison of two pairs holds in one lane at least.
template <class Lanes>
  requires requires(Lanes lanes) { lanes[0] | lanes[1]; }
constexpr bool any(Lanes mask) {
  return (mask[0] | mask[1]) != 0;
}

constexpr bool any(bool condition) {
  return condition;
}

/// A pair of any scalar (automatic differentiation, fixed point, pairs again): one lane after the
/// other.
template <class S>
class Pair {
 public:
  Pair() = default;
  explicit constexpr Pair(const S& both) : first_(both), second_(both) {}
  /// Both lanes from a constant, for scalars that do not convert from numbers by themselves.
  template <class T>
    requires std::is_arithmetic_v<T>
  explicit constexpr Pair(T both) : first_(both), second_(both) {}
  constexpr Pair(const S& first, const S& second) : first_(first), second_(second) {}

  constexpr const S& first() const { return first_; }
  constexpr const S& second() const { return second_; }

  struct Mask {
    decltype(std::declval<S>() < std::declval<S>()) first, second;
    friend constexpr bool any(const Mask& mask) { return any(mask.first) || any(mask.second); }
  };

  [[gnu::always_inline]] friend constexpr Pair operator+(const Pair& a, const Pair& b) {
    return {a.first_ + b.first_, a.second_ + b.second_};
  }
  [[gnu::always_inline]] friend constexpr Pair operator-(const Pair& a, const Pair& b) {
    return {a.first_ - b.first_, a.second_ - b.second_};
  }
  [[gnu::always_inline]] friend constexpr Pair operator*(const Pair& a, const Pair& b) {
    return {a.first_ * b.first_, a.second_ * b.second_};
  }
  [[gnu::always_inline]] friend constexpr Pair operator/(const Pair& a, const Pair& b) {
    return {a.first_ / b.first_, a.second_ / b.second_};
  }
  [[gnu::always_inline]] friend constexpr Pair operator-(const Pair& a) {
    return {-a.first_, -a.second_};
  }
  [[gnu::always_inline]] constexpr Pair& operator+=(const Pair& b) { return *this = *this + b; }
  [[gnu::always_inline]] constexpr Pair& operator-=(const Pair& b) { return *this = *this - b; }
  friend constexpr Mask operator<(const Pair& a, const Pair& b) {
    return {a.first_ < b.first_, a.second_ < b.second_};
  }
  friend Pair sqrt(const Pair& a) {
    using std::sqrt;
    return {sqrt(a.first_), sqrt(a.second_)};
  }
  friend constexpr Pair select(const Mask& condition, const Pair& yes, const Pair& no) {
    return {select(condition.first, yes.first_, no.first_),
            select(condition.second, yes.second_, no.second_)};
  }

 private:
  S first_, second_;
};

namespace detail {
using FloatLanes [[gnu::vector_size(2 * sizeof(float))]] = float;
using DoubleLanes [[gnu::vector_size(2 * sizeof(double))]] = double;
}  // namespace detail

/// float and double: both lanes in one vector register, by the GCC and Clang vector extension.
template <std::floating_point S>
class Pair<S> {
 public:
  Pair() = default;
  explicit constexpr Pair(S both) : lanes_{both, both} {}
  constexpr Pair(S first, S second) : lanes_{first, second} {}

  constexpr S first() const { return lanes_[0]; }
  constexpr S second() const { return lanes_[1]; }

  friend constexpr Pair operator+(Pair a, Pair b) { return of(a.lanes_ + b.lanes_); }
  friend constexpr Pair operator-(Pair a, Pair b) { return of(a.lanes_ - b.lanes_); }
  friend constexpr Pair operator*(Pair a, Pair b) { return of(a.lanes_ * b.lanes_); }
  friend constexpr Pair operator/(Pair a, Pair b) { return of(a.lanes_ / b.lanes_); }
  friend constexpr Pair operator-(Pair a) { return of(-a.lanes_); }
  constexpr Pair& operator+=(Pair b) { return *this = *this + b; }
  constexpr Pair& operator-=(Pair b) { return *this = *this - b; }
  friend constexpr auto operator<(Pair a, Pair b) { return a.lanes_ < b.lanes_; }
  friend Pair sqrt(Pair a) { return {std::sqrt(a.lanes_[0]), std::sqrt(a.lanes_[1])}; }
  template <class Mask>
  friend constexpr Pair select(Mask condition, Pair yes, Pair no) {
    return of(condition ? yes.lanes_ : no.lanes_);
  }

 private:
  using Lanes =
      std::conditional_t<sizeof(S) == sizeof(float), detail::FloatLanes, detail::DoubleLanes>;
  static constexpr Pair of(Lanes lanes) {
    Pair pair;
    pair.lanes_ = lanes;
    return pair;
  }
  Lanes lanes_;
};

}  // namespace smaservo

template <class S>
struct std::numeric_limits<smaservo::Pair<S>> : std::numeric_limits<S> {};
