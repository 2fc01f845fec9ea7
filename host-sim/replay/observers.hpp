#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/replay/run_settings.hpp"
#include "model/wire/wire.hpp"
#include "observer/estimate.hpp"

namespace smaservo::replay {

/// An observer chosen at run time.
class AnyObserver {
 public:
  virtual ~AnyObserver() = default;
  /// A measurement and the time since the one before, of any length: substeps are made as needed.
  virtual void advance(const Measurement<double>& measurement, double dt_s) = 0;
  virtual Estimate<double> estimate() const = 0;
};

/// What an observer of any kind starts from.
struct ObserverStart {
  const Wire<double>& wire;
  const RunSettings& settings;
  const Measurement<double>& first;
  double ambient_K;
};

struct ObserverKind {
  std::string_view name;
  std::string_view meaning;
  std::unique_ptr<AnyObserver> (*make)(const ObserverStart& from);
};
const std::vector<ObserverKind>& observer_kinds();

/// Throws UserError for a name that does not exist.
void require_observer(std::string_view name);

/// Throws UserError for a name that does not exist.
std::unique_ptr<AnyObserver> make_observer(std::string_view name, const Wire<double>& wire,
                                           const RunSettings& settings,
                                           const Measurement<double>& first, double ambient_K);

}  // namespace smaservo::replay
