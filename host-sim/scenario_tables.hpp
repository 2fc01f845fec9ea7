#pragma once
// Tables that both kinds of scenarios have.

#include "hal/sim/simulated_bench.hpp"
#include "host-sim/toml_table.hpp"

namespace smaservo {

/// Throws UserError.
Load read_load(Table table);

}  // namespace smaservo
