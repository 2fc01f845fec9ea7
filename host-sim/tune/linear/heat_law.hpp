#pragma once
// The device's heat law and loss compensation near a state. The device computes both from the wire
// of the file, whatever the real wire is.

#include "firmware/prepared.hpp"
#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

class HeatLaw {
 public:
  /// `nominal` must have many stops.
  HeatLaw(const Settings<double>& settings, const TunedPlant& plant, const Branches& nominal);

  /// Slope of the law's heat over the error of the strain, in J (per strain of 1), for an error of
  /// 1 % of the stroke: the greatest slope of all estimates within `off` of this share of the
  /// stroke. 0 for a wire in the state `turned`.
  double max_J(Motion motion, double share, double off) const;

  /// Slope over temperature of the loss that the device compensates, at the temperature of the
  /// file's wire at this share.
  double loss_slope_W_K(Motion motion, double share) const;

 private:
  struct Stop {
    Motion motion;
    double share, heat_J, loss_slope_W_K;
  };
  std::vector<Stop> stops_;
};

}  // namespace smaservo::tune
