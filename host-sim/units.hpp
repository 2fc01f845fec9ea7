#pragma once
// The two choices of units in which programs show values.

#include <cstdint>

#include "model/units.hpp"

namespace smaservo {

enum class Units : std::uint8_t {
  bench,  ///< degC, MPa, mA, mW, um, mm/s, %; ohm, V and N are the same in both
  si,     ///< K, Pa, A, W, m, m/s, 1
};

/// The unit of this choice for values of a kind; SI's own where the kind has no unit of the bench.
Unit unit_in(Kind kind, Units units);

}  // namespace smaservo
