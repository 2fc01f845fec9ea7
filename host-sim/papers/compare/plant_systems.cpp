// Strain from kinetics and a heat balance, without feedback.

#include <cmath>
#include <fmt/format.h>

#include "host-sim/papers/compare/system.hpp"
#include "host-sim/papers/fits/plant_fit.hpp"
#include "host-sim/papers/fits/preisach_fit.hpp"
#include "model/papers/duhem.hpp"
#include "model/papers/liang_rogers.hpp"

namespace smaservo::compare {
namespace {

/// The temperatures at which a transformation of the wire begins and ends at a stress.
struct Span {
  double start_K, finish_K;
};
Span span(const Surface<double>& surface, double stress_Pa) {
  const Isobar<double> at = isobar(surface, stress_Pa);
  return {at.start_K, at.start_K + 1 / at.per_K};
}

/// The rise of a start temperature with stress, in K per Pa.
double rise_K_Pa(const Surface<double>& surface) {
  constexpr double high_Pa = 300e6;
  return (span(surface, high_Pa).start_K - span(surface, 0).start_K) / high_Pa;
}

template <class K>
using Adjustables = std::vector<fits::Adjustable<fits::PlantModel<K>>>;

/// The parameters that every wire has besides its kinetics, with the deviations that `identify`
/// uses.
template <class K>
Adjustables<K> common() {
  using Model = fits::PlantModel<K>;
  return {
      {"martensite strain", [](Model& m, double u) { m.material.martensite.strain += 0.008 * u; }},
      {"zero of strain",
       [](Model& m, double u) {
         m.material.martensite.strain += 0.005 * u;
         m.material.r_phase.strain += 0.005 * u;
         m.material.austenite.strain += 0.005 * u;
       }},
      {"martensite modulus",
       [](Model& m, double u) { m.material.martensite.modulus_Pa *= std::exp(0.4 * u); }},
      {"specific heat",
       [](Model& m, double u) { m.heat.specific_heat_J_kgK *= std::exp(0.12 * u); }},
      {"latent heat",
       [](Model& m, double u) {
         m.heat.latent_m2a_J_kg *= std::exp(0.25 * u);
         m.heat.latent_r2a_J_kg *= std::exp(0.25 * u);
       }},
      {"convection", [](Model& m, double u) { m.heat.convection_W_m2K *= std::exp(0.3 * u); }},
      {"its slope", [](Model& m, double u) { m.heat.convection_W_m2K2 *= std::exp(0.5 * u); }}};
}

/// Starts with all combinations of shifts of the first two deviations. A branch that is more than
/// its width away from the wire's would lead to a local minimum.
std::vector<std::vector<double>> shifted_starts(std::size_t count) {
  std::vector<std::vector<double>> starts;
  for (const double heating : {0.0, -0.75, 0.75, -1.5, 1.5, -2.5, 2.5}) {
    for (const double cooling : {0.0, -0.75, 0.75, -1.5, 1.5, -2.5, 2.5}) {
      starts.emplace_back(count, 0.0);
      starts.back()[0] = heating;
      starts.back()[1] = cooling;
    }
  }
  return starts;
}

template <class K>
System fitted(const char* name, const char* meaning, const fits::PlantModel<K>& prior,
              Adjustables<K> adjustables, const std::vector<identify::Run>& runs, int threads) {
  for (const fits::Adjustable<fits::PlantModel<K>>& one : common<K>()) {
    adjustables.push_back(one);
  }
  const fits::PlantModel<K> model =
      fits::fit_plant(prior, adjustables, runs, shifted_starts(adjustables.size()), threads);
  return {name, meaning, static_cast<int>(adjustables.size()), "",
          [model](const identify::Run& run) {
            return fits::driven_strain(model, fits::every_row(run));
          }};
}

}  // namespace

System duhem(const Wire<double>& from, const std::vector<identify::Run>& runs, int threads) {
  using K = papers::Duhem<double>;
  using Model = fits::PlantModel<K>;
  const Surface<double> a2m = first_surface(from.kinetics.a2m_a2r);
  const auto process_of = [](const Surface<double>& surface) {
    const Span at = span(surface, 0);
    // There are about four deviations between start and finish.
    return K::Process{0.5 * (at.start_K + at.finish_K),
                      0.25 * std::abs(at.finish_K - at.start_K) + 1, rise_K_Pa(surface)};
  };
  const Model prior{
      {process_of(from.kinetics.m2a), process_of(a2m)}, from.material, from.heat, from.geometry};
  return fitted<K>(
      "Duhem", "001: two phases, Gaussian slopes, with a heat balance", prior,
      {{"heating centre", [](Model& m, double u) { m.kinetics.m2a.centre_K += 8 * u; }},
       {"cooling centre", [](Model& m, double u) { m.kinetics.a2m.centre_K += 8 * u; }},
       {"heating deviation",
        [](Model& m, double u) { m.kinetics.m2a.deviation_K *= std::exp(0.6 * u); }},
       {"cooling deviation",
        [](Model& m, double u) { m.kinetics.a2m.deviation_K *= std::exp(0.6 * u); }},
       {"heating slope", [](Model& m, double u) { m.kinetics.m2a.stress_K_Pa += 0.04e-6 * u; }},
       {"cooling slope", [](Model& m, double u) { m.kinetics.a2m.stress_K_Pa += 0.04e-6 * u; }}},
      runs, threads);
}

System liang_rogers(const Wire<double>& from, const std::vector<identify::Run>& runs, int threads) {
  using K = papers::LiangRogers<double>;
  using Model = fits::PlantModel<K>;
  const Surface<double> a2m = first_surface(from.kinetics.a2m_a2r);
  const Surface<double> a2r = second_surface(from.kinetics.a2m_a2r);
  // A Clausius-Clapeyron slope must be positive and finite.
  const auto process_of = [](const Surface<double>& surface) {
    const Span at = span(surface, 0);
    return papers::CosineProcess<double>{at.start_K, at.finish_K,
                                         1 / std::max(rise_K_Pa(surface), 0.02e-6)};
  };
  const Model prior{{process_of(from.kinetics.m2a), process_of(a2m), process_of(a2r)},
                    from.material,
                    from.heat,
                    from.geometry};
  const auto move = [](papers::CosineProcess<double>& process, double by_K) {
    process.start_K += by_K;
    process.finish_K += by_K;
  };
  const auto widen = [](papers::CosineProcess<double>& process, double u) {
    const double middle_K = 0.5 * (process.start_K + process.finish_K);
    process.start_K = middle_K + (process.start_K - middle_K) * std::exp(0.6 * u);
    process.finish_K = middle_K + (process.finish_K - middle_K) * std::exp(0.6 * u);
  };
  return fitted<K>(
      "Liang-Rogers", "002 section 6: three phases, cosines, with a heat balance", prior,
      {{"A_s, A_f", [move](Model& m, double u) { move(m.kinetics.m2a, 8 * u); }},
       {"M_s, M_f", [move](Model& m, double u) { move(m.kinetics.a2m, 8 * u); }},
       {"R_s, R_f", [move](Model& m, double u) { move(m.kinetics.a2r, 6 * u); }},
       {"A_f - A_s", [widen](Model& m, double u) { widen(m.kinetics.m2a, u); }},
       {"M_s - M_f", [widen](Model& m, double u) { widen(m.kinetics.a2m, u); }},
       {"R_s - R_f", [widen](Model& m, double u) { widen(m.kinetics.a2r, u); }},
       {"C_A", [](Model& m, double u) { m.kinetics.m2a.stress_Pa_K *= std::exp(0.3 * u); }},
       {"C_M", [](Model& m, double u) { m.kinetics.a2m.stress_Pa_K *= std::exp(0.3 * u); }},
       {"C_R", [](Model& m, double u) { m.kinetics.a2r.stress_Pa_K *= std::exp(0.5 * u); }},
       {"R-phase strain", [](Model& m, double u) { m.material.r_phase.strain += 0.003 * u; }}},
      runs, threads);
}

}  // namespace smaservo::compare
