
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <numbers>

#include "firmware/control/trajectory.hpp"
#include "firmware/parameters/parameters.hpp"
#include "host-sim/tune/limits.hpp"
#include "host-sim/tune/linear/heat_law.hpp"
#include "host-sim/tune/linear/uncertainty.hpp"
#include "host-sim/tune/output/rounding.hpp"
#include "model/files/error.hpp"
#include "observer/kalman.hpp"

namespace smaservo::tune {
namespace {

/// The time constant of a loop is at least this many periods. It is then slow compared to effects
/// that its model lacks, such as the filters of the front end and the wire's cold ends.
constexpr double loop_periods = 10;
/// A variable responds to heat in a state if its slope is at least this share of its maximum over
/// the states.
constexpr double min_slope = 0.25;
/// The noise of the resistance may change the power by this share of the power that holds the wire.
constexpr double noise_share = 0.1;
constexpr int law_stops = 49;
/// The margins of a loop with an integral part: 60° of phase, so that a step response does not
/// oscillate.
constexpr AskedMargins damped{2, std::numbers::pi / 3, 2};

/// Slope of the controlled variable over temperature, positive if it moves in the direction that
/// its loop expects.
double slope_1_K(LoopName name, const OperatingPoint& p) {
  switch (name) {
    case LoopName::strain:
      return -p.strain_1_K;
    case LoopName::resistance:
      return -p.ohm_1_K;
    case LoopName::force:
      return p.load_N_K;
    case LoopName::temperature:
      break;
  }
  return 1;
}

LoopGains<double>& gains(LoopName name, Settings<double>& s) {
  switch (name) {
    case LoopName::temperature:
      return s.temperature;
    case LoopName::resistance:
      return s.resistance;
    case LoopName::force:
      return s.force;
    case LoopName::strain:
      break;
  }
  return s.strain;
}

std::vector<Situation> all_situations(const TuneTask& task, const Settings<double>& bare,
                                      const Branches& fine, double max_K) {
  const HeatLaw law(bare, task.plant, fine);
  // The estimate is assumed to be off by twice the wire's accuracy.
  const double off = 2 * task.plant.wire.accuracy.strain / std::max(fine.stroke(), 1e-6);
  std::vector<Situation> all;
  const std::vector<TunedPlant> plants = uncertain_plants(task.plant, task.members, task.seed);
  for (std::size_t i = 0; i < plants.size(); ++i) {
    for (const OperatingPoint& p : trace_branches(plants[i], max_K).points) {
      all.push_back({i, p, law.max_J(p.motion, p.share, i == 0 ? 0 : off),
                     law.loss_slope_W_K(p.motion, p.share)});
    }
  }
  return all;
}

/// The states in which the variable responds to heat.
std::vector<Situation> answering(LoopName name, const std::vector<Situation>& situations) {
  double max = 0;
  for (const Situation& s : situations) {
    max = std::max(max, slope_1_K(name, s.point));
  }
  std::vector<Situation> all;
  std::ranges::copy_if(situations, std::back_inserter(all), [&](const Situation& s) {
    const bool moves = name == LoopName::temperature || s.point.motion != Motion::turned;
    return moves && max > 0 && min_slope * max <= slope_1_K(name, s.point);
  });
  return all;
}

/// One of the loops while its gains are being determined.
class Design {
 public:
  Design(LoopName name, const std::vector<Situation>& situations, double period_s)
      : name_(name),
        period_s_(period_s),
        target_s_(loop_periods * period_s),
        answering_(answering(name, situations)),
        share_(static_cast<double>(answering_.size()) / static_cast<double>(situations.size())) {}

  bool possible() const { return !answering_.empty(); }

  LinearLoop linear(const Situation& s, const LoopGains<double>& gains,
                    double feed_forward_s) const {
    const bool strain = name_ == LoopName::strain;
    const OperatingPoint& p = s.point;
    return {period_s_,
            1,
            p.capacity_J_K,
            p.loss_slope_W_K,
            slope_1_K(name_, p),
            name_ == LoopName::force ? KalmanTuning<double>{}.stress_filter_s : 0,
            name_ == LoopName::temperature ? 0 : s.believed_W_K,
            strain ? s.law_J / feed_forward_s : 0,
            gains};
  }

  bool keeps(const LoopGains<double>& gains, double feed_forward_s,
             const AskedMargins& asked = {}) const {
    return std::ranges::all_of(answering_, [&](const Situation& s) {
      return asked.kept(margins(linear(s, gains, feed_forward_s)));
    });
  }

  /// The deadbeat time of the heat law: ten periods; down to five if otherwise the planner's lead
  /// would delay a wire that stretches at `fastest_1_s`; more until the margins are kept.
  double feed_forward_s(const LoopGains<double>& gains, double fastest_1_s) const {
    const double lead_s = Trajectory<double>::lead / fastest_1_s;
    double time_s = std::clamp(lead_s, 0.5 * target_s_, target_s_);
    while (!keeps(gains, time_s)) {
      time_s *= 1.1;
      require_found(time_s < 1e3 * target_s_);
    }
    return rounded_up(time_s);
  }

  /// Proportional gain by lambda tuning, K = C/(y' τ) in the state where that is least, at most
  /// `max`, and reduced until the margins are kept; then the fastest integral that leaves 60° of
  /// phase, at most 1/(4 τ).
  void tune(LoopGains<double>& gains, double max) const {
    const double target_s =
        name_ == LoopName::force ? 2 * KalmanTuning<double>{}.stress_filter_s : target_s_;
    double K = max;
    for (const Situation& s : answering_) {
      K = std::min(K, s.point.capacity_J_K / (slope_1_K(name_, s.point) * target_s));
    }
    gains.proportional = rounded_down(K);
    gains.integral_1_s = 0;
    const double first = gains.proportional;
    while (!keeps(gains, 1)) {
      gains.proportional = rounded_down(0.85 * gains.proportional);
      require_found(1e-3 * first < gains.proportional);
    }
    gains.integral_1_s = rounded_down(0.25 / target_s);
    while (!keeps(gains, 1, damped)) {
      gains.integral_1_s = rounded_down(0.8 * gains.integral_1_s);
      require_found(1e-6 < gains.integral_1_s);
    }
    gains.tracking_s = rounded_up(std::max(target_s_, 0.5 / gains.integral_1_s));
  }

  DesignedLoop result(const LoopGains<double>& gains, double feed_forward_s) const {
    DesignedLoop d{name_, possible(), share_, {}, {}, {}, {}, {}};
    bool first = true, first_nominal = true;
    for (const Situation& s : answering_) {
      const LinearLoop loop = linear(s, gains, feed_forward_s);
      const Margins m = margins(loop);
      if (first || m.phase_rad < d.worst.phase_rad) {
        d.worst_at = s;
      }
      d.worst = first ? m : worse(d.worst, m);
      first = false;
      d.loops.push_back(loop);
      if (s.member == 0) {
        d.nominal = first_nominal ? m : worse(d.nominal, m);
        first_nominal = false;
        d.nominal_loops.push_back(loop);
      }
    }
    return d;
  }

  /// The greatest K at which the noise of the resistance changes the power by no more than its
  /// share.
  double max_by_noise(const Settings<double>& s) const {
    double max = 1e6;
    for (const Situation& at : answering_) {
      const double power_W = at.point.loss_W;
      const double current_A = std::max(std::sqrt(power_W / at.point.ohm), s.limits.min_current_A);
      max = std::min(max, noise_share * power_W /
                              resistance_noise_ohm(s.measurement, at.point.ohm, current_A));
    }
    return max;
  }

 private:
  void require_found(bool found) const {
    if (!found) {
      throw files::UserError(
          fmt::format("{}: no gains keep the margins; the file's wire.accuracy.strain is "
                      "too coarse for this wire",
                      loop_text(name_)));
    }
  }

  LoopName name_;
  double period_s_, target_s_;
  std::vector<Situation> answering_;
  double share_;
};

DesignedLoop design(LoopName name, Proposal& p) {
  Settings<double>& s = p.settings;
  const Design d(name, p.situations, s.timing.period_s);
  LoopGains<double>& q = gains(name, s);
  if (!d.possible()) {
    return {name, false, 0, {}, {}, {}, {}, {}};
  }
  if (name == LoopName::strain) {
    s.feed_forward_s = d.feed_forward_s(q, p.branches.fastest_cooling_1_s);
  } else {
    d.tune(q, name == LoopName::resistance ? d.max_by_noise(s) : 1e6);
  }
  return d.result(q, s.feed_forward_s);
}

}  // namespace

const char* loop_text(LoopName name) {
  switch (name) {
    case LoopName::temperature:
      return "temperature";
    case LoopName::resistance:
      return "resistance";
    case LoopName::force:
      return "force";
    case LoopName::strain:
      break;
  }
  return "strain";
}

Proposal propose(const TuneTask& task) {
  Proposal p{};
  const double max_K =
      task.plant.wire.limits.temperature_K - default_settings<double>().limits.hot_spot_K;
  const Branches fine = trace_branches(task.plant, max_K, law_stops);
  p.branches = trace_branches(task.plant, max_K);
  require_motion(task, p.branches);
  choose_limits(task, p);
  p.situations = all_situations(task, p.settings, fine, max_K);
  for (const LoopName name : loop_names) {
    p.loops.push_back(design(name, p));
  }
  p.settings.resistance.dead_band = rounded_up(resistance_dead_band_ohm(p));
  p.settings.strain.dead_band = min_dead_band(task, p);
  return p;
}

}  // namespace smaservo::tune
