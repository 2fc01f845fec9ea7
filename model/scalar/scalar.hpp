#pragma once
// The operations that the core needs of every scalar beyond its arithmetic, which is: + - * /,
// their assignments, the unary minus and the comparisons. -x must have the bits of 0 - x except for
// the sign of an IEEE zero, and nothing in the core may depend on that sign.

#include <cmath>

namespace smaservo {

// For other scalars isfinite() is found in their own namespace.
using std::isfinite;

/// A number that is not known when it is compiled, or comes from a table.
template <class S>
constexpr S scalar(double x) {
  if constexpr (requires { S::of(x); }) {
    return S::of(x);
  } else {
    return static_cast<S>(x);
  }
}

template <class S>
struct Product {
  S a, b;
};

/// start + Σ a b, from left to right; a scalar with a cheaper way (add_products) uses it.
template <class S, class... More>
constexpr S sum_of_products(const S& start, const Product<S>& first, const More&... more) {
  if constexpr (requires { S::add_products(start, first, more...); }) {
    return S::add_products(start, first, more...);
  } else if constexpr (sizeof...(more) == 0) {
    return start + first.a * first.b;
  } else {
    return sum_of_products(start + first.a * first.b, more...);
  }
}
/// Σ a b
template <class S, class... More>
constexpr S sum_of_products(const Product<S>& first, const Product<S>& second,
                            const More&... more) {
  if constexpr (requires { S::add_products(first, second, more...); }) {
    return S::add_products(first, second, more...);
  } else {
    return sum_of_products(first.a * first.b, second, more...);
  }
}

}  // namespace smaservo
