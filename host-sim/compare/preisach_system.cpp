// Strain by the Preisach model of paper 003 and a heat balance.

#include <algorithm>
#include <fmt/format.h>

#include "host-sim/compare/plant_fit.hpp"
#include "host-sim/compare/preisach_fit.hpp"
#include "host-sim/compare/system.hpp"
#include "host-sim/identify/steady_load.hpp"
#include "host-sim/output_file.hpp"

namespace smaservo {
namespace {

using Ihyp = ThreePhase<double>;
using Relays = Preisach<double>;

/// A run in its identification: at most so many rows, evenly.
constexpr std::size_t most_rows = 4000;

PlantModel<Ihyp> ihyp_model(const Wire<double>& wire) {
  return {wire.kinetics, wire.material, wire.heat, wire.geometry};
}

bool constant_stress(const Run& run) {
  return quantile(run.stress_Pa, 0.95) - quantile(run.stress_Pa, 0.05) < 5e6;
}

/// The run as if it had been made in a bath of the temperatures that the wire had.
Run in_bath(const Wire<double>& wire, const Run& run) {
  Run bath{};
  bath.name = run.name;
  bath.kind = RunKind::bath;
  const double stress_Pa = quantile(run.stress_Pa, 0.5);
  const std::size_t every = (run.strain.size() + most_rows - 1) / most_rows;
  std::size_t i = 0;
  drive_plant(ihyp_model(wire), every_row(run), [&](const auto& /*params*/, const auto& state) {
    if (i % every == 0) {
      bath.temperature_K.push_back(Plant<Ihyp>::temperature_K(state));
      bath.strain.push_back(run.strain[i]);
      bath.stress_Pa.push_back(stress_Pa);
    }
    ++i;
  });
  return bath;
}

int weights_of(const PreisachWire& wire) {
  // Every cell of the grid, and two strains for each stress; the shift.
  const auto nodes = static_cast<int>(wire.kinetics.node_K.size());
  return static_cast<int>(wire.kinetics.stress_count) * (nodes * (nodes - 1) / 2 + 2) + 1;
}

}  // namespace

System preisach(const Wire<double>& identified, const std::vector<Run>& runs) {
  std::vector<Run> baths;
  std::string unused;
  for (const Run& run : runs) {
    if (constant_stress(run)) {
      baths.push_back(in_bath(identified, run));
    } else {
      unused += fmt::format("{}{}", unused.empty() ? "not used, since their stress varies: " : ", ",
                            run.name);
    }
  }
  const PreisachFit fit = fit_preisach(baths, StressShift::fitted);
  const auto drive = [fit, identified](const Run& run) {
    const PlantModel<Relays> model{fit.wire.kinetics, identified.material, identified.heat,
                                   identified.geometry};
    std::vector<double> strain;
    drive_plant(model, every_row(run), [&](const auto& params, const auto& state) {
      const double martensite = params.ends.average(Plant<Relays>::phases(state)).martensite;
      strain.push_back(fit.wire.strain(martensite, Relays::drive(state.kinetics).stress_Pa));
    });
    return strain;
  };
  const std::string remark =
      fit.remark.empty() || unused.empty() ? fit.remark + unused : fit.remark + "; " + unused;
  return {"Preisach", "003: relays weighed by stress, with ihyp's heat balance",
          weights_of(fit.wire), remark, drive};
}

}  // namespace smaservo
