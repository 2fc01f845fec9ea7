#pragma once

#include <string>

#include "host-sim/identify/runs/run.hpp"

namespace smaservo::identify {

/// Checks what read_run() promises of a run. Throws UserError.
void check_run(const Run& run, const Geometry<double>& geometry);

/// The signs, which are a part of that.
void check_signs(const Run& run, const Geometry<double>& geometry);

/// Throws a UserError that begins with the run's name.
[[noreturn]] void fail(const Run& run, const std::string& what);

}  // namespace smaservo::identify
