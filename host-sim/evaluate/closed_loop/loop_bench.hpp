#pragma once
// A closed loop for judging controllers: a unit on a simulated board, driven step by step.

#include <cstdint>

#include "firmware/bench/scenario/units.hpp"
#include "firmware/device/device.hpp"
#include "hal/sim/board.hpp"

namespace smaservo::evaluate {

/// The device's settings for this wire at the beginning of every run.
Settings<double> loop_settings(const Wire<double>& wire);

/// The load and surroundings of a unit, and the errors of its sensors.
struct LoopConditions {
  hal::Load load;
  double ambient_K = room_K;
  double draught = 1;
  double resistance_gain = 1;
  double load_gain = 1;
};

/// A unit on its board, at 1 kHz with 16 bits and a converter of 0.5 A.
class LoopBench {
 public:
  static constexpr double step_s = 1e-3;

  LoopBench(const bench::WireUnit& unit, const LoopConditions& conditions, std::uint64_t seed);

  /// Reads the sensors at this instant. drive() then simulates one period.
  Inputs<double> read();
  void drive(double current_A);

  hal::SimBoard& board() { return board_; }
  hal::SimTruth truth() const { return board_.truth(); }
  /// The highest temperature so far anywhere in the wire.
  double peak_K() const { return peak_K_; }

 private:
  hal::SimBoard board_;
  double peak_K_ = 0;
};

}  // namespace smaservo::evaluate
