#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "model/files/wire_file.hpp"
#include "observer/estimate.hpp"

namespace smaservo {

/// An observer chosen at run time.
class AnyObserver {
 public:
  virtual ~AnyObserver() = default;
  /// A measurement and the time since the one before, of any length: substeps are made as needed.
  virtual void advance(const Measurement<double>& measurement, double dt_s) = 0;
  virtual Estimate<double> estimate() const = 0;
};

struct ObserverKind {
  std::string_view name;
  std::string_view meaning;
};
const std::vector<ObserverKind>& observer_kinds();

/// Key of an observer's settings in --set, with default and meaning.
struct ObserverSetting {
  std::string key;  ///< "kalman.ambient_walk_K"
  double value;
};
/// What they are for this wire when nothing is set.
std::vector<ObserverSetting> observer_settings(const Wire<double>& wire);

/// Throws UserError for a setting that does not exist or a value that is not allowed.
void check_observer_settings(const Wire<double>& wire, const std::vector<Override>& settings);

/// Throws UserError for a name or a setting that does not exist, or a value that is not allowed.
std::unique_ptr<AnyObserver> make_observer(std::string_view name, const Wire<double>& wire,
                                           const std::vector<Override>& settings,
                                           const Measurement<double>& first, double ambient_K);

}  // namespace smaservo
