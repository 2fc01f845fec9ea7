#pragma once
// A unit's commissioning run as somebody without a displacement sensor records it, and where its
// end truly was.

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/bench/scenario/units.hpp"
#include "host-sim/commission/commission.hpp"
#include "host-sim/evaluate/runs/runs.hpp"
#include "host-sim/simulate/simulate.hpp"

namespace smaservo::test {

struct CommissionedRun {
  explicit CommissionedRun(hal::Family family, std::uint64_t seed)
      : unit(bench::random_unit(family, seed)), type(unit.type_file()) {
    run.name = "run.csv";
    run.kind = identify::RunKind::joule;
    const double area_m2 = type.geometry.area_m2();
    simulate::simulate_rows(evaluate::commissioning_run(unit),
                            [&](const simulate::SimulatedRow& row) {
                              run.time_s.push_back(row.time_s);
                              run.current_A.push_back(row.current_A);
                              run.voltage_V.push_back(row.voltage_V);
                              run.stress_Pa.push_back(row.load_N / area_m2);
                              strain.push_back(row.strain);
                            });
  }

  /// Without error; `zero_m` is the displacement of a wire of its own length.
  commission::Anchor read(double time_s, double zero_m = 0) const {
    const auto row = static_cast<std::size_t>(1e3 * time_s);
    return {time_s, zero_m - strain[row] * type.geometry.length_m, 0.02e-3};
  }
  std::vector<commission::Anchor> read_cold_and_hot(double zero_m = 0) const {
    return {read(evaluate::commissioning_readings_s[0], zero_m),
            read(evaluate::commissioning_readings_s[1], zero_m)};
  }

  bench::WireUnit unit;
  Wire<double> type;
  identify::Run run{};
  std::vector<double> strain;
};

}  // namespace smaservo::test
