#pragma once
// Runs as a laboratory would record them, of a wire that is simple enough to know by heart.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {

inline constexpr Geometry<double> recorded_wire{0.1, 76e-6};

/// One heating from 20 to 120 degC in the first two fifths of the rows, and cooling in the others.
struct Recording {
  std::vector<double> time_s, temperature_degC, strain, ohm, current_A, voltage_V;

  explicit Recording(std::size_t rows = 200) {
    for (std::size_t i = 0; i < rows; ++i) {
      const double u = static_cast<double>(i) / static_cast<double>(rows - 1);
      const double warm = std::min(u / 0.4, (1 - u) / 0.6);
      const double T = 20 + 100 * warm;
      const double martensite = 0.5 - 0.5 * std::tanh((T - (u < 0.4 ? 80 : 60)) / 6);
      time_s.push_back(0.1 * static_cast<double>(i));
      temperature_degC.push_back(T);
      strain.push_back(0.001 + 0.04 * martensite);
      ohm.push_back(19 + 3 * martensite + 0.003 * T);
      current_A.push_back(0.25 * warm);
      voltage_V.push_back(current_A.back() * ohm.back());
    }
  }
};

struct RecordedColumn {
  std::string name;
  std::vector<double> values;
};

inline std::string csv(const std::vector<RecordedColumn>& columns) {
  std::string text;
  for (const RecordedColumn& column : columns) {
    text += (text.empty() ? "" : ",") + column.name;
  }
  for (std::size_t i = 0; i < columns.front().values.size(); ++i) {
    for (const RecordedColumn& column : columns) {
      text += fmt::format("{}{}", &column == &columns.front() ? '\n' : ',', column.values.at(i));
    }
  }
  text += '\n';
  return text;
}

inline identify::RunOptions of_recorded_wire() {
  return {recorded_wire, 150e6, {}, {}};
}

inline identify::Run run_of(const std::vector<RecordedColumn>& columns,
                            const identify::RunOptions& options = of_recorded_wire()) {
  const TemporaryFolder folder;
  return identify::read_run(folder.write("run.csv", csv(columns)), options);
}

/// As a converter of this step would deliver them, within its range.
inline std::vector<double> converted(std::vector<double> values, double step, double low = -1e9,
                                     double high = 1e9) {
  for (double& value : values) {
    value = std::round(std::clamp(value, low, high) / step) * step;
  }
  return values;
}

inline std::vector<double> times(double factor, std::vector<double> values) {
  for (double& value : values) {
    value *= factor;
  }
  return values;
}

/// A bath run without resistance.
inline std::string bath_file(double stress_MPa = 150) {
  const Recording r;
  return csv({{"temperature_degC", r.temperature_degC},
              {"strain_ref", r.strain},
              {"stress_MPa", std::vector<double>(r.strain.size(), stress_MPa)}});
}

}  // namespace smaservo::test
