#pragma once
// The wire behind a simulated board, as a scenario's [plant] table says.

#include <cstdint>
#include <memory>
#include <string_view>

#include "hal/sim/simulated_wire.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::files {
class TomlFile;
class TomlTable;
}  // namespace smaservo::files

namespace smaservo::bench {

enum class PlantFamily : unsigned char { lumped, ihyp, sublayers, free_energy, smooth_hardening };
std::string_view plant_name(PlantFamily family);
PlantFamily plant_family(hal::Family family);

/// The simulated wire as it really is, which the device does not know.
struct PlantSetup {
  PlantFamily family;
  files::WireDescription wire;
  /// Standard deviation of the transition temperatures along the wire; a lumped wire has none.
  double scatter_K;
  hal::Structure structure;  ///< of the family
  std::uint64_t seed;        ///< draws the scatter
};
std::unique_ptr<hal::SimulatedWire> make_plant(const PlantSetup& plant);

/// Reads the keys family, unit or wire, and scatter_K. Throws UserError.
PlantSetup read_plant(const files::TomlFile& file, files::TomlTable& table, std::uint64_t seed);

}  // namespace smaservo::bench
