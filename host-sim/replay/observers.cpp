#include "host-sim/replay/observers.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/files/error.hpp"
#include "observer/line.hpp"
#include "observer/multiple_model.hpp"
#include "observer/open_loop.hpp"
#include "observer/substepping.hpp"

namespace smaservo {
namespace {

template <StrainObserver O>
class Running final : public AnyObserver {
 public:
  Running(const typename O::Params& params, const Measurement<double>& first, double ambient_K)
      : params_(params), state_(O::start(params, first, ambient_K)) {}

  void advance(const Measurement<double>& measurement, double dt_s) override {
    O::advance(params_, state_, measurement, dt_s);
  }
  Estimate<double> estimate() const override { return O::estimate(params_, state_); }

 private:
  typename O::Params params_;
  typename O::State state_;
};

struct TuningField {
  const char* key;
  double KalmanTuning<double>::* value;
};

using Tuning = KalmanTuning<double>;
constexpr TuningField tuning_fields[] = {
    {"kalman.heat_error", &Tuning::heat_error},
    {"kalman.fraction_noise", &Tuning::fraction_noise},
    {"kalman.ambient_walk_K", &Tuning::ambient_walk_K},
    {"kalman.loss_walk", &Tuning::loss_walk},
    {"kalman.resistance_walk", &Tuning::resistance_walk},
    {"kalman.resistance_model_sd", &Tuning::resistance_model_sd},
    {"kalman.stress_filter_s", &Tuning::stress_filter_s},
    {"kalman.start_temperature_sd_K", &Tuning::start_temperature_sd_K},
    {"kalman.start_fraction_sd", &Tuning::start_fraction_sd},
    {"kalman.start_ambient_sd_K", &Tuning::start_ambient_sd_K},
    {"kalman.start_loss_sd", &Tuning::start_loss_sd},
    {"kalman.start_resistance_sd", &Tuning::start_resistance_sd},
    {"kalman.ambient_range_K", &Tuning::ambient_range_K},
    {"kalman.loss_range", &Tuning::loss_range},
    {"kalman.resistance_range", &Tuning::resistance_range},
    {"kalman.hottest_K", &Tuning::hottest_K},
    {"kalman.reported", &Tuning::reported},
    {"kalman.strain_model_sd", &Tuning::strain_model_sd},
};

double positive_number(const Override& setting) {
  double value = 0;
  const char* stop = setting.second.data() + setting.second.size();
  const auto [at, error] = std::from_chars(setting.second.data(), stop, value);
  if (error != std::errc{} || at != stop || !(value > 0 && value < 1e9)) {
    throw UserError(fmt::format("--set {} = {}: must be a number between 0 and 1e9", setting.first,
                                setting.second));
  }
  return value;
}

Tuning tuning_from(const Wire<double>& wire, const std::vector<Override>& settings) {
  Tuning tuning = kalman_tuning(wire.accuracy);
  for (const Override& setting : settings) {
    const auto* field = std::ranges::find(tuning_fields, setting.first, &TuningField::key);
    if (field == std::end(tuning_fields)) {
      std::vector<std::string_view> keys;
      for (const TuningField& known : tuning_fields) {
        keys.emplace_back(known.key);
      }
      throw UserError(fmt::format("--set {}: unknown key; the observer has: {}", setting.first,
                                  fmt::join(keys, ", ")));
    }
    tuning.*(field->value) = positive_number(setting);
  }
  if (tuning.loss_range < 1) {
    throw UserError(
        fmt::format("--set kalman.loss_range = {}: must be at least 1", tuning.loss_range));
  }
  return tuning;
}

}  // namespace

const std::vector<ObserverKind>& observer_kinds() {
  static const std::vector<ObserverKind> kinds{
      {"kalman", "the three-phase model, corrected by the resistance"},
      {"open-loop", "the model alone, from power and stress"},
      {"line", "a straight line from resistance to strain"}};
  return kinds;
}

std::vector<ObserverSetting> observer_settings(const Wire<double>& wire) {
  std::vector<ObserverSetting> all;
  const Tuning defaults = kalman_tuning(wire.accuracy);
  for (const TuningField& field : tuning_fields) {
    all.push_back({field.key, defaults.*(field.value)});
  }
  return all;
}

void check_observer_settings(const Wire<double>& wire, const std::vector<Override>& settings) {
  tuning_from(wire, settings);
}

std::unique_ptr<AnyObserver> make_observer(std::string_view name, const Wire<double>& wire,
                                           const std::vector<Override>& settings,
                                           const Measurement<double>& first, double ambient_K) {
  const auto model = plant_params(wire);
  const Tuning tuning = tuning_from(wire, settings);
  if (name == "kalman") {
    return std::make_unique<Running<Substepping<MultipleModelFilter<double>>>>(
        MultipleModelFilter<double>::Params{model, tuning}, first, ambient_K);
  }
  if (name == "open-loop") {
    return std::make_unique<Running<Substepping<OpenLoopObserver<double>>>>(
        OpenLoopObserver<double>::Params{model}, first, ambient_K);
  }
  if (name == "line") {
    return std::make_unique<Running<LineObserver<double>>>(LineObserver<double>::Params{model},
                                                           first, ambient_K);
  }
  std::vector<std::string_view> names;
  for (const ObserverKind& kind : observer_kinds()) {
    names.push_back(kind.name);
  }
  throw UserError(
      fmt::format("--observer {}: no such observer; there are: {}", name, fmt::join(names, ", ")));
}

}  // namespace smaservo
