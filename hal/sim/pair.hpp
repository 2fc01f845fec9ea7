#pragma once
// Two wires that pull against each other: one gains the length that the other loses, and the same
// force acts in both.

#include "hal/sim/board.hpp"

namespace smaservo::hal {

class SimPair {
 public:
  /// Both boards are at their first frame, at rest under loads of the same force, which have no
  /// effect afterwards. The boards must have the same period and outlive the pair.
  SimPair(SimBoard& first, const Geometry<double>& first_wire, SimBoard& second,
          const Geometry<double>& second_wire);

  /// Does SimBoard::read() for both boards. The stress added to the first wire acts as an external
  /// force against the second wire. Cost: about ten steps of each wire, since the force is found by
  /// bisection and secants: the slope of the length over the force jumps where a wire turns from
  /// stretching to shortening.
  std::array<ReadStatus, 2> read(Frame& first, Frame& second);

  double force_N() const { return force_N_; }

 private:
  /// The length by which both wires together would be too long under this force.
  double excess_m(double force_N) const;
  double balanced_N() const;

  SimBoard& first_;
  SimBoard& second_;
  Geometry<double> first_wire_, second_wire_;
  double space_m_;
  double force_N_;
};

}  // namespace smaservo::hal
