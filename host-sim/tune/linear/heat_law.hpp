#pragma once
// What the device's heat law and loss compensation do near a state: from the file's wire, whatever
// the real one is.

#include "firmware/prepared.hpp"
#include "host-sim/tune/linear/operating_points.hpp"

namespace smaservo::tune {

class HeatLaw {
 public:
  /// `nominal` with many stops.
  HeatLaw(const Settings<double>& settings, const TunedPlant& plant, const Branches& nominal);

  /// Heat by strain in J that the law gives where the estimate says this share of the stroke, for
  /// an error of 1 % of the stroke; the greatest within `off` around it. 0 for a turned wire.
  double max_J(Motion motion, double share, double off) const;

  /// Slope of the loss that the device adds where it is as warm as the file's wire would be.
  double loss_slope_W_K(Motion motion, double share) const;

 private:
  struct Stop {
    Motion motion;
    double share, heat_J, loss_slope_W_K;
  };
  std::vector<Stop> stops_;
};

}  // namespace smaservo::tune
