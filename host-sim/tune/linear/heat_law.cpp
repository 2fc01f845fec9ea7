#include "host-sim/tune/linear/heat_law.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/control/feed_forward.hpp"

namespace smaservo::tune {

HeatLaw::HeatLaw(const Settings<double>& settings, const TunedPlant& plant,
                 const Branches& nominal) {
  const Prepared<double> p = prepare(settings);
  const double small = 0.01 * nominal.stroke();
  for (const OperatingPoint& at : nominal.points) {
    KalmanObserver<double>::State f{};
    f.kinetics = at.state.kinetics;
    f.stress_Pa = at.stress_Pa;
    const double longer = at.motion == Motion::heating ? -small : small;
    const double heat_J =
        at.motion == Motion::turned ? 0 : FeedForward<double>::heat_J(p, f, longer) / -longer;
    stops_.push_back({at.motion, at.share, std::abs(heat_J),
                      p.observer.model.body.loss_slope_W_K(at.temperature_K - plant.ambient_K)});
  }
}

double HeatLaw::max_J(Motion motion, double share, double off) const {
  double max = 0;
  for (const Stop& s : stops_) {
    const double spacing = 0.02;
    if (s.motion == motion && std::abs(s.share - share) <= std::max(off, spacing)) {
      max = std::max(max, s.heat_J);
    }
  }
  return max;
}

double HeatLaw::loss_slope_W_K(Motion motion, double share) const {
  const auto nearest = std::ranges::min_element(stops_, {}, [&](const Stop& s) {
    return std::abs(s.share - share) + (s.motion == motion ? 0 : 1);
  });
  return nearest->loss_slope_W_K;
}

}  // namespace smaservo::tune
