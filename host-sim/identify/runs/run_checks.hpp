#pragma once

#include <string>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::identify {

/// Makes the checks that read_run() promises. Throws UserError.
void check_run(const Run& run, const Geometry<double>& geometry);

/// Checks the signs of the quantities; a part of check_run().
void check_signs(const Run& run, const Geometry<double>& geometry);

/// Throws a UserError that begins with the run's name.
[[noreturn]] void fail(const Run& run, const std::string& what);

}  // namespace smaservo::identify
