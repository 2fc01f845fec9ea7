#pragma once
// The wire behind a simulated board, as a scenario's [plant] table says.

#include <cstdint>
#include <memory>
#include <string_view>

#include "hal/sim/simulated_wire.hpp"
#include "model/files/wire_file.hpp"

namespace smaservo::files {
class TomlFile;
class TomlTable;
}  // namespace smaservo::files

namespace smaservo::bench {

enum class PlantFamily : unsigned char { lumped, ihyp, sublayers };
std::string_view plant_name(PlantFamily family);

/// A wire as it really is.
struct PlantSetup {
  PlantFamily family;
  files::WireDescription wire;
  double scatter_K;  ///< of the transition temperatures along it; none in a lumped one
  hal::SublayerStructure sublayers;  ///< of that family only
  std::uint64_t seed;                ///< of the scatter
};
std::unique_ptr<hal::SimulatedWire> make_plant(const PlantSetup& plant);

/// Takes the keys family, unit or wire and scatter_K. Throws UserError.
PlantSetup read_plant(const files::TomlFile& file, files::TomlTable& table, std::uint64_t seed);

}  // namespace smaservo::bench
