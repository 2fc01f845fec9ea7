#include "firmware/bench/plant_setup.hpp"

#include <array>
#include <random>

#include "firmware/bench/scenario/units.hpp"
#include "hal/sim/lumped_wire.hpp"
#include "model/files/toml/toml_table.hpp"

namespace smaservo::bench {
namespace {

constexpr std::array<std::string_view, 5> plant_names{"lumped", "ihyp", "sublayers", "free-energy",
                                                      "smooth-hardening"};

/// Of a plant that is not lumped.
hal::Family family_of(PlantFamily plant) {
  return hal::families.at(static_cast<std::size_t>(plant) - 1);
}

files::WireDescription named_wire(const files::TomlFile& file, const std::string& name) {
  return files::load_wire(name.ends_with(".toml") ? file.beside(name) : name);
}

}  // namespace

PlantSetup read_plant(const files::TomlFile& file, files::TomlTable& table, std::uint64_t seed) {
  PlantSetup plant{};
  plant.family = table.has("family") ? static_cast<PlantFamily>(table.choice("family", plant_names))
                                     : PlantFamily::ihyp;
  plant.seed = seed;
  if (table.has("unit")) {
    const auto unit_seed = static_cast<std::uint64_t>(table.number("unit", 0, 1e9));
    const WireUnit unit = random_unit(
        plant.family == PlantFamily::lumped ? hal::Family::ihyp : family_of(plant.family),
        unit_seed);
    plant.wire = unit.wire;
    plant.scatter_K = unit.scatter_K;
    plant.structure = unit.structure;
  } else {
    plant.wire =
        named_wire(file, table.has("wire") ? table.text("wire") : std::string(files::default_wire));
    plant.scatter_K = table.number("scatter_K", 0, 20, 0.5);
  }
  return plant;
}

std::string_view plant_name(PlantFamily family) {
  return plant_names.at(static_cast<std::size_t>(family));
}

PlantFamily plant_family(hal::Family family) {
  return static_cast<PlantFamily>(static_cast<std::size_t>(family) + 1);
}

std::unique_ptr<hal::SimulatedWire> make_plant(const PlantSetup& plant) {
  if (plant.family == PlantFamily::lumped) {
    return hal::make_lumped_wire(plant.wire.wire);
  }
  std::mt19937_64 random(plant.seed);
  return hal::make_simulated_wire(family_of(plant.family), plant.wire.wire, plant.structure,
                                  plant.scatter_K, random);
}

}  // namespace smaservo::bench
