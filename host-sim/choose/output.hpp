#pragma once
// A choice of wires as text, as JSON and as panels of a report.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host-sim/choose/choose.hpp"
#include "host-sim/report/panel.hpp"

namespace smaservo::choose {

/// In at most 80 columns.
std::string text(const Task& task, const Choice& choice);
/// As host-sim/page/PROTOCOL.md has it. Courses have at most 200 points.
nlohmann::ordered_json json(const Choice& choice);
std::vector<report::Panel> panels(const Task& task, const Choice& choice);

std::string text(const std::vector<MakersCheck>& checks);
nlohmann::ordered_json json(const std::vector<MakersCheck>& checks);

}  // namespace smaservo::choose
