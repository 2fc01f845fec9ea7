#pragma once
// Wires that are drawn around the preset smartflex-76um, as cells of rows.

#include <cstdint>
#include <vector>

#include "firmware/bench/scenario/units.hpp"
#include "host-sim/campaign/plan.hpp"

namespace smaservo::campaign {

/// The preset itself, as if there were no tolerance.
bench::WireUnit nominal_unit(hal::Family family);

/// `seed`, `family`, how a unit differs from the preset, and then the columns of the results.
std::vector<Column> with_unit_columns(const std::vector<Column>& results);
/// The cells of the former.
Row unit_cells(const bench::WireUnit& unit, std::uint64_t seed);

/// The key `families`: names of families of wires, which trials take in turn. Throws ConfigError.
std::vector<hal::Family> families_of(KindTable& table);

}  // namespace smaservo::campaign
