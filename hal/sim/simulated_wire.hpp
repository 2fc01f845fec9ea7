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
  ihyp,       ///< the observers' transformation curves in 24 segments, loops remembered 24 deep
  sublayers,  ///< model/plants/sublayers.hpp in 12 segments, c(T), resistivities partly in parallel
  free_energy  ///< model/plants/free_energy.hpp in 12 segments, c(T), resistivities in parallel
};
inline constexpr std::array families{Family::ihyp, Family::sublayers, Family::free_energy};
/// Those that observers and control may be tuned with. The others are for tests only.
inline constexpr std::array tuning_families{Family::ihyp, Family::sublayers};
std::string_view family_name(Family family);

/// Parameters of the family sublayers beyond those of a wire.
struct SublayerStructure {
  double m_correlation = 0.6;   ///< SublayerSpread's
  double r_correlation = -0.6;  ///< SublayerSpread's; who becomes martensite late, R-phase early
  double a2m_tail = 1.3;        ///< factor on the spread of A2M below its median
  double a2r_width = 2;         ///< factor on the spread of A2R, so that R-phase peaks at 70 %
  double ramp_K = 1.5;          ///< SublayerSpread's
  double r2a_lead_K = 3;        ///< R2A is so far below M2A where the wire has no R2A of its own
  double bend_K = 1;            ///< A2M is so far above a straight line at 200 MPa; 0 at 400 MPa
  double a2r_K_MPa = 0.01;      ///< added to the slope of A2R with stress
  double parallel_share = 0.5;  ///< DistributedPlant's
  double specific_heat_1_K = 1e-3;  ///< DistributedPlant's
  std::uint64_t seed = 1;           ///< draws the layers
};

/// The layers' thresholds. Without stress they have the 20, 50 and 80 % quantiles of the wire's
/// surfaces, and at 0, 200 and 400 MPa their medians, plus what the structure adds. Their tails are
/// logistic, much shorter than those of the surfaces.
SublayerSpread sublayer_spread(const Wire<double>& wire, const SublayerStructure& structure);

/// Parameters of the family free-energy beyond those of a wire.
struct FreeEnergyStructure {
  double r_correlation = -0.5;      ///< FreeEnergySpread's
  double width_K = 1.5;             ///< FreeEnergySpread's
  double attempt_s = 1e-3;          ///< FreeEnergySpread's
  double coupling_K = 4;            ///< FreeEnergySpread's
  double a2r_width = 2.3;           ///< factor on the spread of A2R, so that R-phase peaks at 70 %
  double r_hysteresis_K = 4;        ///< R2A above A2R; real wires have 2 to 6
  double specific_heat_1_K = 5e-4;  ///< DistributedPlant's
};

/// The medians are those of the wire's surfaces, as in sublayer_spread().
FreeEnergySpread free_energy_spread(const Wire<double>& wire, const FreeEnergyStructure& structure);

class SimulatedWire {
 public:
  struct Surroundings {
    double stress_Pa;
    double ambient_K;  ///< of the air and of the clamps
    double draught;    ///< factor on still-air convection
  };

  virtual ~SimulatedWire() = default;
  /// Puts the wire at rest: cooled to this temperature from far above.
  virtual void rest(double temperature_K, double stress_Pa) = 0;
  /// Gives the whole wire this temperature, without heat balance.
  virtual void soak(double temperature_K, double stress_Pa) = 0;
  /// Does one step; dt_s is up to 1 ms.
  virtual void advance(double current_A, const Surroundings& around, double dt_s) = 0;
  /// The strain after advance() with these arguments; the wire itself does not change.
  virtual double strain_after(double current_A, const Surroundings& around, double dt_s) const = 0;

  virtual double strain() const = 0;
  virtual double resistance_ohm() const = 0;
  virtual double hottest_K() const = 0;
  virtual double average_K() const = 0;
  virtual Phases<double> phases() const = 0;  ///< mean of the whole wire
};

/// What a family has beyond a wire's parameters; the structures of other families do not matter.
struct Structure {
  SublayerStructure sublayers;
  FreeEnergyStructure free_energy;
};

/// The wire is at rest at 25 °C without load. Its scatter is drawn from `random`.
std::unique_ptr<SimulatedWire> make_simulated_wire(Family family, const Wire<double>& wire,
                                                   const Structure& structure, double scatter_K,
                                                   std::mt19937_64& random);

}  // namespace smaservo::hal
