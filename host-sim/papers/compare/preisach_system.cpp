// Strain from the Preisach model of paper 003 and a heat balance.

#include <algorithm>
#include <tuple>

#include "host-sim/identify/runs/steady_load.hpp"
#include "host-sim/papers/compare/system.hpp"
#include "host-sim/papers/fits/plant_fit.hpp"
#include "host-sim/papers/fits/preisach_fit.hpp"

namespace smaservo::compare {
namespace {

using Ihyp = ThreePhase<double>;
using Relays = papers::Preisach<double>;

/// Greatest number of rows of a run that its identification uses; longer runs are thinned evenly.
constexpr std::size_t max_rows = 4000;

fits::PlantModel<Ihyp> ihyp_model(const Wire<double>& wire) {
  return {wire.kinetics, wire.material, wire.heat, wire.geometry};
}

/// The run as if it had been measured in a bath at the temperatures of the wire.
identify::Run in_bath(const Wire<double>& wire, const identify::Run& run, double ambient_K) {
  identify::Run bath{};
  bath.name = run.name;
  bath.kind = identify::RunKind::bath;
  const std::size_t every = (run.strain.size() + max_rows - 1) / max_rows;
  std::size_t i = 0;
  const fits::DrivenSteps steps = fits::every_row(run, ambient_K);
  fits::drive_plant(ihyp_model(wire), steps, [&](const auto& /*params*/, const auto& state) {
    if (i % every == 0) {
      bath.temperature_K.push_back(Plant<Ihyp>::temperature_K(state));
      bath.strain.push_back(run.strain[i]);
      bath.stress_Pa.push_back(steps.stress_Pa[i]);
    }
    ++i;
  });
  return bath;
}

/// Stresses of the runs, at least 20 MPa apart, and at most as many as the model can hold.
std::vector<double> slice_stresses_Pa(const std::vector<identify::Run>& runs) {
  std::vector<double> all;
  for (const identify::Run& run : runs) {
    all.push_back(identify::quantile(run.stress_Pa, 0.02));
    all.push_back(identify::quantile(run.stress_Pa, 0.98));
  }
  std::ranges::sort(all);
  std::vector<double> apart;
  for (const double stress_Pa : all) {
    if (apart.empty() || stress_Pa > apart.back() + 20e6) {
      apart.push_back(stress_Pa);
    }
  }
  constexpr std::size_t max = std::tuple_size_v<decltype(Relays::Params::stress_Pa)>;
  std::vector<double> chosen;
  const std::size_t count = std::min(max, apart.size());
  chosen.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    chosen.push_back(apart[count == 1 ? 0 : i * (apart.size() - 1) / (count - 1)]);
  }
  return chosen;
}

/// The rise of the temperature of M2A with stress, in K per Pa.
double shift_K_Pa(const Wire<double>& wire) {
  const double high_Pa = wire.limits.stress_Pa;
  return wire.kinetics.m2a.start_shift_K(0, high_Pa) / high_Pa;
}

int weights_of(const fits::PreisachWire& wire) {
  // Every cell of the grid and two strains for each stress, and one shift.
  const auto nodes = static_cast<int>(wire.kinetics.node_K.size());
  return static_cast<int>(wire.kinetics.stress_count) * (nodes * (nodes - 1) / 2 + 2) + 1;
}

}  // namespace

System preisach(const IdentifiedWire& identified, const std::vector<identify::Run>& runs) {
  const Wire<double>& wire = identified.wire;
  std::vector<identify::Run> baths;
  baths.reserve(runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    baths.push_back(in_bath(wire, runs[i], identified.ambient_K[i]));
  }
  const fits::PreisachFit fit =
      fits::fit_preisach_histories(baths, slice_stresses_Pa(runs), shift_K_Pa(wire));
  const auto drive = [fit, wire, ambient_K = identified.usual_ambient_K](const identify::Run& run) {
    const fits::PlantModel<Relays> model{fit.wire.kinetics, wire.material, wire.heat,
                                         wire.geometry};
    std::vector<double> strain;
    fits::drive_plant(
        model, fits::every_row(run, ambient_K), [&](const auto& params, const auto& state) {
          const double martensite = params.ends.average(Plant<Relays>::phases(state)).martensite;
          strain.push_back(fit.wire.strain(martensite, Relays::drive(state.kinetics).stress_Pa));
        });
    return strain;
  };
  return {"Preisach", "003: relays weighed by stress, with ihyp's heat balance",
          weights_of(fit.wire), fit.remark, drive};
}

}  // namespace smaservo::compare
