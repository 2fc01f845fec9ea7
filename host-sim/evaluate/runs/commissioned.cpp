#include "host-sim/evaluate/runs/commissioned.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "firmware/bench/dice.hpp"
#include "host-sim/commission/commission.hpp"
#include "host-sim/evaluate/runs/runs.hpp"
#include "host-sim/simulate/simulate.hpp"

namespace smaservo::evaluate {
namespace {

constexpr double reading_sd_m = 0.02e-3;  ///< a caliper's; and that of the wire's length

}  // namespace

Wire<double> commissioned_wire(const bench::WireUnit& unit, Read read) {
  const Wire<double> type = unit.type_file();
  const double area_m2 = type.geometry.area_m2();
  identify::Run run{};
  run.name = "commissioning";
  run.kind = identify::RunKind::joule;
  std::vector<double> strain;
  simulate::simulate_rows(commissioning_run(unit), [&](const simulate::SimulatedRow& row) {
    run.time_s.push_back(row.time_s);
    run.current_A.push_back(row.current_A);
    run.voltage_V.push_back(row.voltage_V);
    run.stress_Pa.push_back(row.load_N / area_m2);
    strain.push_back(row.strain);
  });
  bench::Dice dice(unit.seed + 15485863);
  const double length_error_m = dice.deviation(reading_sd_m);
  std::vector<commission::Anchor> anchors;
  const auto times = read == Read::nothing ? std::span<const double>()
                                           : std::span<const double>(commissioning_readings_s);
  for (const double at_s : times) {
    const auto row = std::ranges::lower_bound(run.time_s, at_s) - run.time_s.begin();
    const double error_m = dice.deviation(reading_sd_m);
    anchors.push_back(
        {at_s,
         length_error_m + error_m - strain[static_cast<std::size_t>(row)] * type.geometry.length_m,
         reading_sd_m});
  }
  commission::CommissionOptions options;
  options.zero = read == Read::lengths ? commission::Zero::length : commission::Zero::common;
  options.length_sd_m = reading_sd_m;
  return commission::commission(type, run, std::move(anchors), options).wire;
}

}  // namespace smaservo::evaluate
