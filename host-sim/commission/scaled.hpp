#pragma once

#include "model/wire/wire.hpp"

namespace smaservo::commission {

/// The wire with all resistivities times this factor.
inline Wire<double> with_resistance(Wire<double> wire, double factor) {
  Material<double>& m = wire.material;
  for (Phase<double>* phase : {&m.martensite, &m.r_phase, &m.austenite}) {
    phase->resistivity_ohm_m *= factor;
    phase->resistivity_ohm_m_K *= factor;
    phase->resistivity_ohm_m_Pa *= factor;
  }
  return wire;
}

}  // namespace smaservo::commission
