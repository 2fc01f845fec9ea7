#include "firmware/daemon/status/warning_journal.hpp"

#include <fmt/format.h>

#include "firmware/safety/standing.hpp"

namespace smaservo::daemon {
namespace {

double seconds(std::uint64_t us) {
  return static_cast<double>(us) * 1e-6;
}

}  // namespace

std::vector<std::string> WarningJournal::lines(std::uint64_t time_us, const WarningCounts& all) {
  if (time_us < time_us_) {
    told_ = {};
  }
  time_us_ = time_us;
  std::vector<std::string> lines;
  for_each_fault(warning_faults, [&](Fault fault) {
    Told& told = told_.at(warning_index(fault));
    const std::uint32_t causes = all.at(warning_index(fault));
    if (causes == told.causes) {
      return;
    }
    if (told.causes == 0) {
      lines.push_back(fmt::format("{:.3f} s: warning {}: {}", seconds(time_us_), fault_name(fault),
                                  fault_row(fault).text));
    } else if (time_us_ - told.time_us >= quiet_us) {
      const std::uint32_t more = causes - told.causes;
      lines.push_back(fmt::format(
          "{:.3f} s: warning {}: its cause has come {} in the last {:.0f} s", seconds(time_us_),
          fault_name(fault), more == 1 ? "once more" : fmt::format("{} times more", more),
          seconds(time_us_ - told.time_us)));
    } else {
      return;
    }
    told = {causes, time_us_};
  });
  return lines;
}

}  // namespace smaservo::daemon
