#include "host-sim/commission/passage.hpp"

#include <cmath>

#include "model/wire/plant.hpp"
#include "observer/multiple_model.hpp"
#include "observer/substepping.hpp"

namespace smaservo::commission {
namespace {

/// The search for the phases at the start is no sign of a wrong wire.
constexpr double settles_s = 0.5;

}  // namespace

Passage pass(const ObservedWire& seen, const Wire<double>& wire) {
  using Filter = MultipleModelFilter<double>;
  using Observer = Substepping<Filter>;
  const identify::ObservedRun& run = seen.run;
  const Observer::Params params{plant_params(wire), kalman_tuning(wire.accuracy)};
  Observer::State state = Observer::start(params, run.seen.front(), seen.ambient_K);
  Passage all{};
  double now_s = 0, sum = 0, time_s = 0;
  std::size_t anchor = 0;
  for (std::size_t i = 0; i < run.dt_s.size(); ++i) {
    const double dt_s = run.dt_s[i];
    Observer::advance(params, state, run.seen[i], dt_s);
    now_s += dt_s;
    const auto& likeliest = Filter::likeliest(state.observer);
    if (run.seen[i].resistance_valid && now_s > settles_s) {
      sum += dt_s * likeliest.innovation_ohm / likeliest.model_ohm;
    }
    time_s += dt_s;
    const bool block_ends = time_s >= block_s;
    const bool read = anchor < seen.anchor_steps.size() && seen.anchor_steps[anchor] == i;
    if (!block_ends && !read) {
      continue;
    }
    const Estimate<double> e = Observer::estimate(params, state);
    for (; anchor < seen.anchor_steps.size() && seen.anchor_steps[anchor] == i; ++anchor) {
      all.at_anchors.push_back(e.strain);
    }
    if (block_ends) {
      all.innovation.push_back(sum / time_s);
      all.time_s.push_back(now_s);
      all.strain.push_back(e.strain);
      all.strain_sd.push_back(e.strain_sd);
      all.resistance_ohm.push_back(run.seen[i].resistance_valid ? run.seen[i].resistance_ohm
                                                                : std::nan(""));
      all.resistance_model_ohm.push_back(likeliest.model_ohm);
      sum = time_s = 0;
    }
  }
  const auto& last = Filter::likeliest(state.observer);
  all.ambient_off_K = last.ambient_K - seen.ambient_K;
  all.loss = last.loss;
  all.resistance = last.resistance;
  return all;
}

double innovation_rms(const Passage& passage) {
  double squares = 0;
  for (const double innovation : passage.innovation) {
    squares += innovation * innovation;
  }
  return std::sqrt(squares / static_cast<double>(passage.innovation.size()));
}

}  // namespace smaservo::commission
