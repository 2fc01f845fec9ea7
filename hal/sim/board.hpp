#pragma once
// A board with a simulated wire behind it, in virtual time: read() lets one period pass. The same
// setup and seed give the same frames.

#include <memory>
#include <random>

#include "hal/board.hpp"
#include "hal/sim/front_end.hpp"
#include "hal/sim/simulated_wire.hpp"

namespace smaservo::hal {

/// What stands around the wire, as events change it.
struct SimSurroundings {
  double ambient_K = 298.15;
  double draught = 1;  ///< factor on still-air convection
  double supply_V = 24;
  double added_stress_Pa = 0;  ///< on top of the load
  double slip = 0;             ///< by which the wire has slipped out of its clamps, as a strain
  double driver_above_K = 10;  ///< temperature of the output stage above ambient
};

struct SimSetup {
  std::int64_t period_ns;
  Converter converter;
  Sensors sensors;
  Load load;
  Geometry<double> geometry;  ///< as it really is
  SimSurroundings surroundings;
  bool reads_supply, reads_ambient, reads_driver;
  std::uint64_t seed;
};

/// What no sensor says, to judge by.
struct SimTruth {
  double strain;  ///< of the wire, with what it has slipped
  double hottest_K;
  double current_A, stress_Pa;
};

class SimBoard {
 public:
  /// The wire rests at ambient temperature under its load.
  SimBoard(std::unique_ptr<SimulatedWire> wire, const SimSetup& setup);

  // A Board. The first frame is that of the wire at rest, at 0 s.
  ReadStatus read(Frame& frame);
  void drive(const DriveCommand& command) { command_ = command; }
  void safe_off() { command_ = {}; }
  void kick() {}  // its lease is the drive command's
  std::int64_t now_ns() const { return time_ns_; }

  SimSurroundings surroundings;
  FrontEndFaults& faults() { return front_end_.faults; }

  SimTruth truth() const;
  const SimulatedWire& wire() const { return *wire_; }

  // The parts of read(), for a load that moves with another board. Parts are of equal length, up to
  // 1 ms; a period has parts() of them, none before the first frame.
  int parts() const { return started_ ? parts_ : 0; }
  double part_s() const { return part_s_; }
  /// The converter's current of the next part.
  void begin_part();
  /// The wire's strain after this part under this stress, with what it has slipped.
  double strain_after(double stress_Pa) const;
  void finish_part(double stress_Pa);
  /// The readings of now.
  ReadStatus sample(Frame& frame);

 private:
  void look();
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
