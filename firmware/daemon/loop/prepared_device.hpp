#pragma once
// A device with the settings that are in force, compiled once for all boards.

#include <cstdint>
#include <memory>

#include "firmware/command.hpp"
#include "firmware/settings.hpp"

namespace smaservo::daemon {

/// Settings with all that follows from them, made outside of the loop.
struct ParameterSet;
struct DeleteParameterSet {
  void operator()(ParameterSet* set) const;
};
using ParameterSetPtr = std::unique_ptr<ParameterSet, DeleteParameterSet>;

/// The number is the recording's name of this change. Settings have passed check().
ParameterSetPtr make_parameter_set(const Settings<double>& settings, std::uint32_t number);
std::uint32_t number_of(const ParameterSet& set);

class PreparedDevice {
 public:
  explicit PreparedDevice(ParameterSetPtr set);
  ~PreparedDevice();
  PreparedDevice(const PreparedDevice&) = delete;
  PreparedDevice& operator=(const PreparedDevice&) = delete;

  /// Device<double>::step(). Nothing is allocated.
  Output<double> step(const Inputs<double>& in, const Command<double>& command, double dt_s);

  /// In force from the next step on. Takes this set and gives the one before, for another thread to
  /// delete.
  ParameterSet* adopt(ParameterSet* set);

 private:
  struct State;
  std::unique_ptr<State> state_;
  ParameterSetPtr set_;
};

}  // namespace smaservo::daemon
