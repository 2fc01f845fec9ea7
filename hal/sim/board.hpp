#pragma once
// A board with a simulated wire, in virtual time: read() advances it by one period. The same setup
// and seed give the same frames.

#include <memory>
#include <random>

#include "hal/board.hpp"
#include "hal/sim/front_end.hpp"
#include "hal/sim/simulated_wire.hpp"

namespace smaservo::hal {

/// The surroundings of the wire, which events can change.
struct SimSurroundings {
  double ambient_K = room_K;
  double draught = 1;  ///< factor on still-air convection
  double supply_V = 24;
  double added_stress_Pa = 0;  ///< stress in addition to the load's
  double slip = 0;             ///< strain by which the wire has slipped out of its clamps
  double stop_strain = 0;      ///< strain below which a hard stop does not let it contract; 0: none
  double driver_above_K = 10;  ///< temperature of the output stage above ambient
};

struct SimSetup {
  std::int64_t period_ns;
  Converter converter;
  Sensors sensors;
  Load load;
  Geometry<double> geometry;  ///< true geometry of the wire
  SimSurroundings surroundings;
  bool reads_supply, reads_ambient, reads_driver;
  std::uint64_t seed;
};

/// The true values, which no sensor shows; control and estimates are judged by them.
struct SimTruth {
  double strain;  ///< strain of the wire, including its slip
  double hottest_K;
  double current_A, stress_Pa;
};

class SimBoard {
 public:
  /// The wire rests at ambient temperature under its load.
  SimBoard(std::unique_ptr<SimulatedWire> wire, const SimSetup& setup);

  // The members that Board requires. The first frame is at 0 s, with the wire at rest.
  ReadStatus read(Frame& frame);
  void drive(const DriveCommand& command) { command_ = command; }
  void safe_off() { command_ = {}; }
  void kick() {}  // no one-shot: the drive command's lease is enforced
  std::int64_t now_ns() const { return time_ns_; }

  SimSurroundings surroundings;
  FrontEndFaults& faults() { return front_end_.faults; }

  SimTruth truth() const;
  const SimulatedWire& wire() const { return *wire_; }

  // The steps of read(), for a load that is coupled to another board. A period consists of parts()
  // parts of equal length, up to 1 ms; before the first frame there are none.
  int parts() const { return started_ ? parts_ : 0; }
  double part_s() const { return part_s_; }
  /// Computes the converter's current in the next part.
  void begin_part();
  /// The strain, including slip, that the wire would have after this part under this stress.
  double strain_after(double stress_Pa) const;
  void finish_part(double stress_Pa);
  /// Reads the sensors now.
  ReadStatus sample(Frame& frame);

 private:
  void look();
  double pull_Pa(double load_Pa) const;
  SimulatedWire::Surroundings around(double stress_Pa) const {
    return {stress_Pa, surroundings.ambient_K, surroundings.draught};
  }

  std::unique_ptr<SimulatedWire> wire_;
  FrontEnd front_end_;
  LoadModel load_;
  std::mt19937_64 load_random_;
  double area_m2_;
  bool reads_supply_, reads_ambient_, reads_driver_;
  std::int64_t period_ns_;
  int parts_;
  double part_s_;
  DriveCommand command_{};
  bool started_ = false;
  std::int64_t time_ns_ = 0;
  double part_began_s_ = 0;
  std::uint32_t sequence_ = 0;
  double strain_ = 0, ohm_ = 0, stress_Pa_;
};

static_assert(Board<SimBoard>);

}  // namespace smaservo::hal
