#pragma once
// The smaller, the nearest within bounds, the positive part, the magnitude: for every scalar, by
// its comparison alone. What is not a number stays so, but for min(), where b comes back.

namespace smaservo {

/// The smaller of two; b where either is not a number.
template <class S>
constexpr S min(const S& a, const S& b) {
  return a < b ? a : b;
}

/// x, or the bound that it is beyond; low must not be above high.
template <class S>
constexpr S clamp(const S& x, const S& low, const S& high) {
  return x < low ? low : high < x ? high : x;
}

/// x, or 0 where it is below.
template <class S>
constexpr S positive(const S& x) {
  return x < S(0) ? S(0) : x;
}

/// |x|, but -0 stays -0.
template <class S>
constexpr S magnitude(const S& x) {
  return x < S(0) ? -x : x;
}

}  // namespace smaservo
