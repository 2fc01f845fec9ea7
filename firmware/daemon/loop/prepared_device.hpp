#pragma once
// A device with the settings that are in force, compiled once for all boards.

#include <cstdint>
#include <memory>

#include "firmware/command.hpp"
#include "firmware/settings.hpp"

namespace smaservo::daemon {

/// Settings and everything that is computed from them, made outside of the loop.
struct ParameterSet;
struct DeleteParameterSet {
  void operator()(ParameterSet* set) const;
};
using ParameterSetPtr = std::unique_ptr<ParameterSet, DeleteParameterSet>;

/// `number` names the change in the recording. The settings must have passed check().
ParameterSetPtr make_parameter_set(const Settings<double>& settings, std::uint32_t number);
std::uint32_t number_of(const ParameterSet& set);
/// Whether adopt() has refused it.
bool is_refused(const ParameterSet& set);

class PreparedDevice {
 public:
  explicit PreparedDevice(ParameterSetPtr set);
  ~PreparedDevice();
  PreparedDevice(const PreparedDevice&) = delete;
  PreparedDevice& operator=(const PreparedDevice&) = delete;

  /// Device<double>::step(). Nothing is allocated.
  Output<double> step(const Inputs<double>& in, const Command<double>& command, double dt_s);

  /// Puts this set in force from the next step on. Returns the one before, which another thread
  /// deletes. While the wire is heated, a set that changes anything that may change only without
  /// current is refused, whatever its maker believed: that set is returned, and marked. Cost beside
  /// the change itself: two reads of each such parameter, about 2 us on a PC.
  ParameterSet* adopt(ParameterSet* set, bool heated);

 private:
  struct State;
  std::unique_ptr<State> state_;
  ParameterSetPtr set_;
};

}  // namespace smaservo::daemon
