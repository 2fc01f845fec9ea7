#pragma once
// Settings for tests: of the reference wire, and random ones that pass every check.

#include <algorithm>
#include <cmath>
#include <random>

#include "firmware/parameters/parameter_check.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo {

template <class S = double>
Settings<S> reference_settings(const char* wire = "smartflex-76um") {
  Settings<double> settings = default_settings<double>();
  settings.wire = files::load_wire(wire).wire;
  return stored_settings<S>(settings);
}

/// A value of the row's range; near `around` for reals, so that sets of them can agree.
template <class S>
Value random_value(const Parameter<S>& row, Value around, std::mt19937& random) {
  if (row.type != ValueType::real) {
    return Value::number(
        std::uniform_int_distribution<std::uint32_t>(row.min.number(), row.max.number())(random));
  }
  const float x = around.real();
  const float near = x == 0.F ? row.max.real() : x;
  const float shifted = x + near * std::uniform_real_distribution<float>(-0.1F, 0.1F)(random);
  return Value::real(std::clamp(shifted, row.min.real(), row.max.real()));
}

/// Each parameter is changed unless the set would become contradictory by it.
template <class S = double>
Settings<S> random_settings(std::mt19937& random) {
  Settings<S> settings = reference_settings<S>();
  for (const Parameter<S>& row : parameters<S>) {
    if (!row.is_used(settings) || row.path.text().starts_with("wire.separate")) {
      continue;
    }
    Settings<S> changed = settings;
    row.set(changed, random_value(row, row.get(settings), random));
    if (check(changed).ok()) {
      settings = changed;
    }
  }
  return settings;
}

}  // namespace smaservo
