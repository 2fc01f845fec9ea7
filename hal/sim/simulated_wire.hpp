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
  free_energy
};
inline constexpr std::array families{Family::ihyp, Family::sublayers, Family::free_energy};
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

class SimulatedWire {
 public:
  struct Surroundings {
    double stress_Pa;
    double ambient_K;  ///< temperature of the air and of the clamps
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
};

/// The wire is at rest at 25 °C without load. Its scatter is drawn from `random`.
std::unique_ptr<SimulatedWire> make_simulated_wire(Family family, const Wire<double>& wire,
                                                   const Structure& structure, double scatter_K,
                                                   std::mt19937_64& random);

}  // namespace smaservo::hal
