#pragma once
// Two wires that pull against each other: what one loses in length the other gains, and one force
// goes through both.

#include "hal/sim/board.hpp"

namespace smaservo::hal {

class SimPair {
 public:
  /// Both boards at their first frame, at rest under loads that give the same force; their loads
  /// mean nothing afterwards. They must outlive the pair and have the same period.
  SimPair(SimBoard& first, const Geometry<double>& first_wire, SimBoard& second,
          const Geometry<double>& second_wire);

  /// As SimBoard::read() of both. The stress added to the first wire comes from outside, against
  /// the second one.
  /// Cost: some ten steps of each wire, as the force is found by bisection and secants: it is a
  /// jump of the slope, not a line, where a wire turns from stretching to shortening.
  std::array<ReadStatus, 2> read(Frame& first, Frame& second);

  double force_N() const { return force_N_; }

 private:
  /// By how much both together would be too long, under this force.
  double excess_m(double force_N) const;
  double balanced_N() const;

  SimBoard& first_;
  SimBoard& second_;
  Geometry<double> first_wire_, second_wire_;
  double space_m_;
  double force_N_;
};

}  // namespace smaservo::hal
