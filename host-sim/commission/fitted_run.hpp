#pragma once
// From the file of a run to what is learned from it: the same for whoever asks.

#include <string>
#include <vector>

#include "host-sim/commission/output.hpp"

namespace smaservo::commission {

/// A run for commission(), of this file. Needs neither a strain nor, with a stress or load in
/// `options`, one of these. Throws UserError or TraceError for what read_run() refuses, and for a
/// run that is not heated by its current.
identify::Run heated_run(const std::string& path, identify::RunOptions options);

/// The fit, with the time that it takes; `run` and `out` are the names by which texts call the
/// files. Throws what commission() throws.
Commissioning fitted_run(files::WireDescription from, const identify::Run& recorded,
                         const std::vector<Anchor>& anchors, const CommissionOptions& options,
                         const std::string& run, const std::string& out);

}  // namespace smaservo::commission
