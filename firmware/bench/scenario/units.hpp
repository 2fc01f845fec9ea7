#pragma once
// Wires drawn at random around the preset, as one piece of wire differs from the next.

#include <cstdint>

#include "hal/sim/simulated_wire.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::bench {

/// One piece of wire, as it really is.
struct WireUnit {
  hal::Family family;
  std::uint64_t seed;  ///< the seed that it was drawn with
  files::WireDescription wire;
  double scatter_K;          ///< of the transition temperatures along the wire
  hal::Structure structure;  ///< of the family

  /// The wire as it is known without a calibration: the preset, with its resistivities scaled to
  /// the resistance of this wire, cold at 25 °C without load (the key wire.resistance).
  Wire<double> type_file() const;
};

/// The preset smartflex-76um with a random deviation of every parameter, and with the structure of
/// the family. The same seed gives the same unit. The standard deviations, beyond 2.5 of which none
/// goes, are: transition temperatures of each process 1.5 K, their slopes with stress 4 %,
/// curvature 10 %, strain 3 %, resistivities 1 %, their change per kelvin 10 %, moduli 8 %, latent
/// heats 6 %, specific heat 4 %, length 0.5 %, diameter 1 %, conductivity to the clamps 10 %.
WireUnit random_unit(hal::Family family, std::uint64_t seed);

}  // namespace smaservo::bench
