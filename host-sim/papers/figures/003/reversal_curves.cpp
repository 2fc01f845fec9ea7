#include "host-sim/papers/figures/003/reversal_curves.hpp"

#include <algorithm>

#include "host-sim/simulate/simulate.hpp"

namespace smaservo::figures {

bench::BathScenario reversal_curves(const Wire<double>& wire, double stress_Pa, int curves) {
  const Isobar<double> m2a = isobar(wire.kinetics.m2a, stress_Pa);
  const Isobar<double> a2m = isobar(first_surface(wire.kinetics.a2m_a2r), stress_Pa);
  // The temperatures lie beyond the tangents' ends, where 3 to 10 % are left: the hyperbolas never
  // end.
  const double cold_K = std::min(a2m.start_K + 1 / a2m.per_K - 25, room_K);
  const double hot_K = m2a.start_K + 1 / m2a.per_K + 20;
  const double first_K = m2a.start_K - 10;
  bench::BathScenario bath{stress_Pa, 0.25, {hot_K, cold_K}, 0.05};
  for (int i = 0; i < curves; ++i) {
    bath.turning_K.push_back(first_K + (hot_K - 5 - first_K) * i / curves);
    bath.turning_K.push_back(cold_K);
  }
  bath.turning_K.push_back(hot_K);
  bath.turning_K.push_back(cold_K);
  return bath;
}

identify::Run bath_run(const bench::Scenario& scenario) {
  identify::Run run{};
  run.name = scenario.note;
  run.kind = identify::RunKind::bath;
  simulate::simulate_bath_rows(scenario, [&](const simulate::SimulatedBathRow& row) {
    run.temperature_K.push_back(row.temperature_K);
    run.stress_Pa.push_back(row.stress_Pa);
    run.strain.push_back(row.strain);
  });
  return run;
}

}  // namespace smaservo::figures
