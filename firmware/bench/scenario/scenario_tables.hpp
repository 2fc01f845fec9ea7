#pragma once
// Tables that both kinds of scenarios have.

#include "hal/sim/simulated_bench.hpp"
#include "model/files/toml/toml_table.hpp"

namespace smaservo::bench {

/// The greatest time in a scenario, in s.
inline constexpr double longest_s = 1e5;

/// Throws UserError.
hal::Load read_load(files::TomlTable table);

}  // namespace smaservo::bench
