#include "host-sim/checks/findings.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <limits>

#include "host-sim/checks/statistics.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::checks {

std::vector<double> heating_K(const Record& record, const Geometry<double>& geometry) {
  if (record.kind == RunKind::bath) {
    return record.temperature_K;
  }
  constexpr double still_air_W_m2K = 100;
  const double delay_s =
      density_kg_m3 * specific_heat_J_kgK * geometry.diameter_m / (4 * still_air_W_m2K);
  std::vector<double> all;
  double now_K = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < record.heated_rows(); ++i) {
    const double settled_K = record.heating_W_at(i) / (still_air_W_m2K * geometry.surface_m2());
    const bool timed = record.kind != RunKind::settled && i > 0 && !record.time_s.empty();
    const double step = timed ? (record.time_s[i] - record.time_s[i - 1]) / delay_s : 1e9;
    now_K = std::isnan(now_K) ? settled_K : now_K + (settled_K - now_K) * -std::expm1(-step);
    all.push_back(now_K);
  }
  return all;
}

std::vector<Finding> find_mistakes(const Record& record, const RecordedWire& wire) {
  constexpr std::size_t few = 20;
  Findings found;
  if (record.lines.empty() && record.stress_Pa.empty() && record.current_A.empty()) {
    return found;
  }
  const std::size_t rows =
      std::max({record.stress_Pa.size(), record.current_A.size(), record.temperature_K.size()});
  check_signs(record, wire, found);
  if (rows >= few) {
    check_converters(record, found);  // before the resistance that they make wrong
  }
  check_units(record, wire, found);
  if (rows >= few) {
    check_sensors(record, found);
    check_time(record, wire, found);
    check_alloy(record, wire, found);
  }
  Findings sorted;
  for (const bool is_error : {true, false}) {
    std::ranges::copy_if(found, std::back_inserter(sorted),
                         [&](const Finding& finding) { return finding.is_error == is_error; });
  }
  return sorted;
}

Judgement judge_mistakes(const Record& record, const RecordedWire& wire,
                         const std::vector<std::string>& allowed) {
  for (const std::string& name : allowed) {
    if (std::ranges::find(check_names, name) == std::end(check_names)) {
      throw files::UserError(fmt::format("--allow {}: there is no such check; there are: {}", name,
                                         fmt::join(check_names, ", ")));
    }
  }
  Judgement judgement;
  for (const Finding& finding : find_mistakes(record, wire)) {
    const bool is_allowed = std::ranges::find(allowed, finding.check) != allowed.end();
    const std::string text = fmt::format("{}: {}", record.name, finding.text);
    if (finding.is_error && !is_allowed && judgement.error.empty()) {
      judgement.error = fmt::format("{} (to go on all the same: --allow {})", text, finding.check);
    } else {
      judgement.warnings.push_back(text);
    }
  }
  return judgement;
}

void refuse_mistakes(const Record& record, const RecordedWire& wire,
                     const std::vector<std::string>& allowed) {
  // The first error ends the program; what else there is may explain it.
  const Judgement judgement = judge_mistakes(record, wire, allowed);
  for (const std::string& warning : judgement.warnings) {
    files::complain("host-sim", warning);
  }
  if (!judgement.error.empty()) {
    throw files::UserError(judgement.error);
  }
}

}  // namespace smaservo::checks
