#include <cmath>
#include <numbers>
#include <random>

#include "host-sim/papers/figures/003/paper_003.hpp"
#include "host-sim/papers/figures/003/reversal_curves.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/units.hpp"

namespace smaservo::figures {
namespace {

constexpr double scatter_K = 0.5;
constexpr std::uint64_t wire_seed = 7;

const files::WireDescription& wire_003() {
  static const files::WireDescription wire = files::load_wire("smartflex-76um");
  return wire;
}

}  // namespace

LoopSetup loop_003() {
  LoopSetup setup{.wire = wire_003().wire, .limit_A = 0.3};
  return setup;
}

FixedController fixed_003(const LoopSetup& setup) {
  return {loop_design(setup), 0.1};
}

AdaptiveController adaptive_003(const LoopSetup& setup) {
  // At 100 to 200 MPa martensite appears below 70 °C and disappears above 85 °C.
  return {loop_design(setup),
          {{zero_degC_K + 50, zero_degC_K + 70, zero_degC_K + 85, zero_degC_K + 100}, 0.98, 3}};
}

std::vector<LoopReference> references_003(bool dynamic) {
  std::vector<LoopReference> all;
  constexpr double duration_s = 100;
  const double sample_s = loop_003().sample_s;
  const auto swing = [](double turns) {
    return 2 / std::numbers::pi * std::asin(std::sin(2 * std::numbers::pi * turns));
  };
  for (int i = 1; i * sample_s <= duration_s; ++i) {
    const double time_s = i * sample_s;
    const double T = 345.15 - (1 - 0.6 * time_s / duration_s) * 40 * swing(time_s / 20 + 0.25);
    const double more_Pa = dynamic ? 35e6 * std::sin(2 * std::numbers::pi * time_s / 13) : 0;
    all.push_back({T, 150e6 + more_Pa});
  }
  return all;
}

fits::PreisachFit fit_003(hal::Family family, fits::StressShift shift) {
  std::vector<identify::Run> runs;
  for (double stress_Pa = 100e6; stress_Pa < 201e6; stress_Pa += 25e6) {
    runs.push_back(bath_run({"reversal curves",
                             wire_003(),
                             wire_seed,
                             scatter_K,
                             family,
                             {},
                             reversal_curves(wire_003().wire, stress_Pa, 20)}));
  }
  return fits::fit_preisach(runs, shift);
}

Validation validation_003(hal::Family family, const fits::PreisachWire& model, bool dynamic) {
  using K = papers::Preisach<double>;
  const LoopSetup setup = loop_003();
  AdaptiveController controller = adaptive_003(setup);
  Validation v{run_loop(setup, controller, references_003(dynamic)), {}, {}, 0};
  std::mt19937_64 random(wire_seed + 1);
  const auto wire = hal::make_simulated_wire(family, wire_003().wire, {}, scatter_K, random);
  const double stress_Pa = v.rows.front().truth.stress_Pa;
  wire->rest(setup.ambient_K, stress_Pa);
  K::State s = K::rest(model.kinetics, {setup.ambient_K, stress_Pa});
  for (const LoopRow& row : v.rows) {
    wire->soak(row.truth.temperature_K, row.truth.stress_Pa);
    K::advance(model.kinetics, s, {row.truth.temperature_K, row.truth.stress_Pa});
    v.strain.push_back(wire->strain());
    v.model.push_back(model.strain(s.martensite, row.truth.stress_Pa));
    v.rms += std::pow((v.model.back() - v.strain.back()) / 0.04, 2);
  }
  v.rms = std::sqrt(v.rms / static_cast<double>(v.rows.size()));
  return v;
}

}  // namespace smaservo::figures
