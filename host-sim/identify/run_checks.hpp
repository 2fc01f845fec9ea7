#pragma once

#include "host-sim/identify/run.hpp"

namespace smaservo {

/// What read_run() promises of a run. Throws UserError.
void check_run(const Run& run, const Geometry<double>& geometry);

}  // namespace smaservo
