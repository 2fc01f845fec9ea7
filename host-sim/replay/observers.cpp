#include "host-sim/replay/observers.hpp"

#include <concepts>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/files/error.hpp"
#include "observer/line.hpp"
#include "observer/multiple_model.hpp"
#include "observer/open_loop.hpp"
#include "observer/substepping.hpp"

namespace smaservo::replay {
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

template <StrainObserver O>
std::unique_ptr<AnyObserver> running(const typename O::Params& params, const ObserverStart& from) {
  return std::make_unique<Running<O>>(params, from.first, from.ambient_K);
}

std::unique_ptr<AnyObserver> kalman(const ObserverStart& from) {
  const auto tuning = with_settings(kalman_tuning(from.wire.accuracy), from.settings);
  return running<Substepping<MultipleModelFilter<double>>>({plant_params(from.wire), tuning}, from);
}

std::unique_ptr<AnyObserver> open_loop(const ObserverStart& from) {
  return running<Substepping<OpenLoopObserver<double>>>({plant_params(from.wire)}, from);
}

std::unique_ptr<AnyObserver> line(const ObserverStart& from) {
  return running<LineObserver<double>>({plant_params(from.wire)}, from);
}

}  // namespace

const std::vector<ObserverKind>& observer_kinds() {
  static const std::vector<ObserverKind> kinds{
      {"kalman", "the three-phase model, corrected by the resistance", kalman},
      {"open-loop", "the model alone, from power and stress", open_loop},
      {"line", "a straight line from resistance to strain", line}};
  return kinds;
}

namespace {

const ObserverKind& kind_of(std::string_view name) {
  std::vector<std::string_view> names;
  for (const ObserverKind& kind : observer_kinds()) {
    if (kind.name == name) {
      return kind;
    }
    names.push_back(kind.name);
  }
  throw files::UserError(
      fmt::format("--observer {}: no such observer; there are: {}", name, fmt::join(names, ", ")));
}

}  // namespace

void require_observer(std::string_view name) {
  kind_of(name);
}

std::unique_ptr<AnyObserver> make_observer(std::string_view name, const Wire<double>& wire,
                                           const RunSettings& settings,
                                           const Measurement<double>& first, double ambient_K) {
  return kind_of(name).make({wire, settings, first, ambient_K});
}

}  // namespace smaservo::replay
