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

}  // namespace

const std::vector<ObserverKind>& observer_kinds() {
  static const std::vector<ObserverKind> kinds{
      {"kalman", "the three-phase model, corrected by the resistance"},
      {"open-loop", "the model alone, from power and stress"},
      {"line", "a straight line from resistance to strain"}};
  return kinds;
}

std::unique_ptr<AnyObserver> make_observer(std::string_view name, const Wire<double>& wire,
                                           const RunSettings& settings,
                                           const Measurement<double>& first, double ambient_K) {
  const auto model = plant_params(wire);
  const auto tuning = with_settings(kalman_tuning(wire.accuracy), settings);
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
  throw files::UserError(
      fmt::format("--observer {}: no such observer; there are: {}", name, fmt::join(names, ", ")));
}

}  // namespace smaservo::replay
