#pragma once
// What the core asks of every scalar beyond its arithmetic.

#include <cmath>

namespace smaservo {

// Those of other scalars are found beside them.
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

}  // namespace smaservo
