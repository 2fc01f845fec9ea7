#include "host-sim/evaluate/runs/calibrate.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "host-sim/evaluate/runs/runs.hpp"
#include "host-sim/simulate/simulate.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::evaluate {
identify::Run calibration_measurement(const bench::WireUnit& unit, std::size_t index) {
  const double area_m2 = unit.type_file().geometry.area_m2();
  identify::Run run{};
  run.name = fmt::format("{} MPa", calibration_stresses_MPa.at(index));
  run.kind = identify::RunKind::joule;
  simulate::simulate_rows(calibration_run(unit, index), [&](const simulate::SimulatedRow& row) {
    run.time_s.push_back(row.time_s);
    run.current_A.push_back(row.current_A);
    run.voltage_V.push_back(row.voltage_V);
    run.stress_Pa.push_back(row.load_N / area_m2);
    run.strain.push_back(row.strain);
    run.resistance_ohm.push_back(row.voltage_V / row.current_A);
  });
  return run;
}

files::WireDescription calibrate(const bench::WireUnit& unit, const std::function<bool()>& proceed,
                                 identify::Structure structure) {
  const Wire<double> from = unit.type_file();
  std::vector<identify::Run> runs;
  runs.reserve(calibration_stresses_MPa.size());
  for (std::size_t i = 0; i < calibration_stresses_MPa.size(); ++i) {
    runs.push_back(calibration_measurement(unit, i));
  }
  identify::FitOptions options;
  options.structure = structure;
  options.proceed = [&](const identify::FitProgress& /*at*/) { return proceed(); };
  const identify::FitResult fit = identify::fit_wire(from, runs, options);
  return {fmt::format("{} {}", hal::family_name(unit.family), unit.seed),
          fit.wire,
          {{"all", fmt::format("fitted to {} simulated runs", runs.size())}}};
}

Wire<double> calibrated_wire(const bench::WireUnit& unit, const std::string& folder,
                             identify::Structure structure) {
  const auto file =
      std::filesystem::path(folder) / calibrated_name(unit.family, unit.seed, structure);
  if (!folder.empty() && std::filesystem::exists(file)) {
    return files::load_wire(file.string()).wire;
  }
  const files::WireDescription found = calibrate(unit, [] { return true; }, structure);
  if (!folder.empty()) {
    files::OutputFile output(file.string());
    output.write(files::to_toml(found));
    output.commit();
  }
  return found.wire;
}

std::string calibrated_name(hal::Family family, std::uint64_t seed, identify::Structure structure) {
  const std::string forced = structure == identify::Structure::automatic
                                 ? ""
                                 : fmt::format("-{}", identify::structure_name(structure));
  return fmt::format("{}-{}{}.toml", hal::family_name(family), seed, forced);
}

}  // namespace smaservo::evaluate
