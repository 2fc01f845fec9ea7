#pragma once
// What commissioning has found, as a wire file, as text, as JSON and as a report.

#include <string>
#include <vector>

#include "host-sim/commission/commission.hpp"
#include "host-sim/report/panel.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::commission {

/// The result and what it was made from.
struct Commissioning {
  files::WireDescription from;
  std::string run;  ///< file
  std::string out;  ///< file
  Zero zero;
  Commissioned found;
  double elapsed_s = 0;
};

/// The wire with the sources of its numbers. Throws UserError if a wire file could not hold it.
files::WireDescription commissioned_wire(const Commissioning& all, const std::string& name);

/// For a terminal of 80 columns.
std::string text(const Commissioning& all);
std::string json(const Commissioning& all);
/// Strain with readings, and resistance, before and after.
std::vector<report::Panel> panels(const Commissioning& all);

}  // namespace smaservo::commission
