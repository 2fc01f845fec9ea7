// The project's own model and observer, and the estimator of paper 002.

#include <fmt/format.h>
#include <limits>

#include "host-sim/papers/compare/system.hpp"
#include "host-sim/papers/fits/plant_fit.hpp"
#include "host-sim/papers/fits/strain_resistance_fit.hpp"
#include "host-sim/replay/measurement_params.hpp"
#include "host-sim/replay/observers.hpp"
#include "model/files/error.hpp"

namespace smaservo::compare {
namespace {

std::vector<double> nothing_of(const identify::Run& run) {
  return std::vector<double>(run.strain.size(), std::numeric_limits<double>::quiet_NaN());
}

std::vector<double> observed(const IdentifiedWire& identified, const identify::Run& run) {
  const Wire<double>& wire = identified.wire;
  const MeasurementParams<double> measurement = replay::measurement_params(wire, {});
  std::unique_ptr<replay::AnyObserver> observer;
  std::vector<double> strain;
  strain.reserve(run.time_s.size());
  for (std::size_t i = 0; i < run.time_s.size(); ++i) {
    const Sample<double> sample{run.current_A[i], run.voltage_V[i],
                                run.stress_Pa[i] * measurement.area_m2};
    const Measurement<double> m = measure(measurement, sample);
    if (observer) {
      observer->advance(m, run.time_s[i] - run.time_s[i - 1]);
    } else {
      const double ambient_K =
          run.ambient_K.empty() ? identified.usual_ambient_K : run.ambient_K.front();
      observer = replay::make_observer("kalman", wire, {}, m, ambient_K);
    }
    strain.push_back(observer->estimate().strain);
  }
  return strain;
}

}  // namespace

System stress_strain_resistance(const std::vector<identify::Run>& runs) {
  std::vector<identify::Run> usable;
  std::string unused;
  for (const identify::Run& run : runs) {
    if (run.resistance_ohm.empty()) {
      unused += (unused.empty() ? "; not used, having no resistance: " : ", ") + run.name;
    } else {
      usable.push_back(run);
    }
  }
  if (usable.empty()) {
    throw files::UserError("no run has a resistance");
  }
  const fits::StrainResistanceFit fit = fits::identify_strain_resistance(usable);
  const std::string remark = fit.order == 0 ? "one load only: holds at its stress alone"
                                            : fmt::format("{} loads, polynomials of order {}",
                                                          fit.levels.size(), fit.order);
  return {
      "stress-strain-resistance", "002: lines over resistance by stress, with transitions",
      4 * (fit.order + 1) + 2, remark + unused, [params = fit.params](const identify::Run& run) {
        return run.resistance_ohm.empty() ? nothing_of(run) : fits::estimate_strain(params, run);
      }};
}

System ihyp_alone(const IdentifiedWire& identified) {
  const Wire<double>& wire = identified.wire;
  const fits::PlantModel<ThreePhase<double>> model{wire.kinetics, wire.material, wire.heat,
                                                   wire.geometry};
  return {"ihyp", "000: three phases, return-point memory, heat balance", identified.parameters, "",
          [model, ambient_K = identified.usual_ambient_K](const identify::Run& run) {
            return fits::driven_strain(model, fits::every_row(run, ambient_K));
          }};
}

System ihyp_observer(const IdentifiedWire& identified) {
  return {"ihyp observer", "the same, corrected by the resistance; not in a bath",
          identified.parameters, "", [identified](const identify::Run& run) {
            // In a bath there is no power from which the observer could compute the temperature.
            return run.kind == identify::RunKind::joule ? observed(identified, run)
                                                        : nothing_of(run);
          }};
}

}  // namespace smaservo::compare
