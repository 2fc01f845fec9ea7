#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host-sim/replay/replay.hpp"
#include "host-sim/units.hpp"

namespace smaservo::replay {

/// Writes one HTML file that opens without a network: numbers, plots, wire and settings. Throws
/// UserError.
void write_report(const std::string& path, const ReplayOptions& options, const ReplayResult& result,
                  Units units);

/// The numbers of a run for a terminal: what was read, and the error of every observer.
std::string summary(const ReplayOptions& options, const ReplayResult& result);

/// The same for machines, as one JSON object, and its text.
nlohmann::ordered_json summary_object(const ReplayOptions& options, const ReplayResult& result);
std::string summary_json(const ReplayOptions& options, const ReplayResult& result);

}  // namespace smaservo::replay
