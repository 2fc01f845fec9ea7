#pragma once
// The default wire as a calibrated wire of another kind than paper 000's: its loops have an order,
// its curves have tapers, and R2A has a surface of its own (model/README.md).

#include <string>

#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::test {

/// Odds and tapers are those of the wire in tests/host-sim/identify/identify_kept_test.cpp. R2A
/// begins and ends several kelvin before M2A, as in tests/golden/evaluate/sublayers-1000.toml.
inline const Wire<double>& ordered_wire() {
  static const Wire<double> ordered = [] {
    Wire<double> wire = files::load_wire(std::string(files::default_wire)).wire;
    ThreePhase<double>::Params& k = wire.kinetics;
    k.loop_odds = 12;
    k.m2a.taper = 0.6;
    k.a2m_a2r.taper = Pair<double>(1.5, 0.1);
    k.separate_r2a = true;
    k.r2a = {{zero_degC_K + 66, 0.12e-6, 0}, {zero_degC_K + 71, 0.13e-6, 0}, {3, 0}, {0.5, 0}, 0.6};
    return wire;
  }();
  return ordered;
}

}  // namespace smaservo::test
