#pragma once
// The wires behind simulated traces, in families that differ from the observers' model. All have
// temperature distributed along the wire, clamps at ambient temperature, transition
// temperatures that scatter along the wire, and convection after Churchill and Chu.
// host-sim/simulate/README.md compares them.

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <string_view>

#include "model/plants/free_energy.hpp"
#include "model/plants/smooth_hardening.hpp"
#include "model/plants/sublayers.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::hal {

enum class Family : unsigned char {
  ihyp,  ///< the observers' transformation curves in 24 segments, up to 24 remembered loops
  /// model/plants/sublayers.hpp in 12 segments, temperature-dependent specific heat, resistivities
  /// partly in parallel.
  sublayers,
  /// model/plants/free_energy.hpp in 12 segments, temperature-dependent specific heat,
  /// resistivities in parallel.
  free_energy,
  /// model/plants/smooth_hardening.hpp in 24 segments, short ones at the ends; clamps that become
  /// warm, martensite's strain that grows with stress, resistivities of a mixture of grains.
  smooth_hardening
};
inline constexpr std::array families{Family::ihyp, Family::sublayers, Family::free_energy,
                                     Family::smooth_hardening};
/// The families with which observers and control may be tuned. The others are for tests only.
inline constexpr std::array tuning_families{Family::ihyp, Family::sublayers};
std::string_view family_name(Family family);

/// Parameters of the family `sublayers` in addition to those of a wire.
struct SublayerStructure {
  double m_correlation = 0.6;  ///< as in SublayerSpread
  /// As in SublayerSpread; negative: a layer that becomes martensite late becomes R-phase early.
  double r_correlation = -0.6;
  double a2m_tail = 1.3;  ///< factor on the spread of A2M below its median
  double a2r_width = 2;   ///< factor on the spread of A2R, so that R-phase peaks at 70 %
  double ramp_K = 1.5;    ///< as in SublayerSpread
  double r2a_lead_K = 3;  ///< distance of R2A below M2A if the wire has no R2A surface of its own
  double bend_K = 1;  ///< height of A2M above a straight line over stress at 200 MPa; 0 at 400 MPa
  double a2r_K_MPa = 0.01;          ///< added to the slope of A2R with stress
  double parallel_share = 0.5;      ///< as in DistributedPlant
  double specific_heat_1_K = 1e-3;  ///< as in DistributedPlant
  std::uint64_t seed = 1;           ///< random seed for the ranks of the layers
};

/// The layers' thresholds. Without stress they have the 20, 50 and 80 % quantiles of the wire's
/// surfaces, and at 0, 200 and 400 MPa their medians; the structure's changes are added. Their
/// tails are logistic, much shorter than those of the surfaces.
SublayerSpread sublayer_spread(const Wire<double>& wire, const SublayerStructure& structure);

/// Parameters of the family `free_energy` in addition to those of a wire.
struct FreeEnergyStructure {
  double r_correlation = -0.5;      ///< as in FreeEnergySpread
  double width_K = 1.5;             ///< as in FreeEnergySpread
  double attempt_s = 1e-3;          ///< as in FreeEnergySpread
  double coupling_K = 4;            ///< as in FreeEnergySpread
  double a2r_width = 2.3;           ///< factor on the spread of A2R, so that R-phase peaks at 70 %
  double r_hysteresis_K = 4;        ///< distance of R2A above A2R; real wires have 2 to 6
  double specific_heat_1_K = 5e-4;  ///< as in DistributedPlant
};

/// The medians are those of the wire's surfaces, as in sublayer_spread().
FreeEnergySpread free_energy_spread(const Wire<double>& wire, const FreeEnergyStructure& structure);

/// Parameters of the family `smooth_hardening` in addition to those of a wire.
struct SmoothHardeningStructure {
  /// Exponents of the hardening, at the start and at the end of M2A, A2M and A2R. R2A has those of
  /// A2R the other way round: it is A2R's curve, shifted.
  double m2a_first = 0.9, m2a_last = 0.7;
  double a2m_first = 0.7, a2m_last = 0.6;
  double a2r_first = 0.9, a2r_last = 0.3;
  double a2r_width = 1.35;          ///< factor on the spread of A2R, so that R-phase peaks at 75 %
  double r_hysteresis_K = 4;        ///< distance of R2A above A2R; real wires have 2 to 6
  double strain_deficit = 0.15;     ///< as in SmoothHardeningNumbers
  double saturation_Pa = 70e6;      ///< as in SmoothHardeningNumbers
  double parallel_share = 2.0 / 3;  ///< as in DistributedPlant; grains that lie in all directions
  double specific_heat_1_K = 3e-4;  ///< as in DistributedPlant; Debye's curve and the electrons'
  /// Factor on the conductivity towards the clamps: martensite, in which the ends stay, conducts
  /// heat about half as well as austenite.
  double conduction = 0.8;
  /// As in DistributedPlant: of a crimp of some 10 mm² in air, which the wire warms by a fifth of
  /// what it is above the air itself.
  double clamp_resistance_m = 0.3e-3;
};

/// Without stress M2A and A2M have the wire's medians and distances from 20 to 80 %, A2R has its
/// temperature at 20 %. Over stress martensite's medians go up by the work on the strain, and at
/// 400 MPa are the wire's; R-phase's go up as its strain and latent heat demand.
SmoothHardeningNumbers smooth_hardening_numbers(const Wire<double>& wire,
                                                const SmoothHardeningStructure& structure);

class SimulatedWire {
 public:
  struct Surroundings {
    double stress_Pa;
    double ambient_K;  ///< temperature of the air and of what the clamps are fastened to
    double draught;    ///< factor on still-air convection
  };

  virtual ~SimulatedWire() = default;
  /// Puts the wire at rest: cooled to this temperature from far above.
  virtual void rest(double temperature_K, double stress_Pa) = 0;
  /// Sets the whole wire to this temperature, without heat balance.
  virtual void soak(double temperature_K, double stress_Pa) = 0;
  /// Does one step; dt_s is up to 1 ms.
  virtual void advance(double current_A, const Surroundings& around, double dt_s) = 0;
  /// The strain that advance() with these arguments would give; the wire itself does not change.
  virtual double strain_after(double current_A, const Surroundings& around, double dt_s) const = 0;

  virtual double strain() const = 0;
  virtual double resistance_ohm() const = 0;
  virtual double hottest_K() const = 0;
  virtual double average_K() const = 0;
  virtual Phases<double> phases() const = 0;  ///< mean of the whole wire
};

/// The parameters of a family in addition to those of a wire; only the chosen family's are used.
struct Structure {
  SublayerStructure sublayers;
  FreeEnergyStructure free_energy;
  SmoothHardeningStructure smooth_hardening;
};

/// The wire is at rest at 25 °C without load. Its scatter is drawn from `random`.
std::unique_ptr<SimulatedWire> make_simulated_wire(Family family, const Wire<double>& wire,
                                                   const Structure& structure, double scatter_K,
                                                   std::mt19937_64& random);

}  // namespace smaservo::hal
