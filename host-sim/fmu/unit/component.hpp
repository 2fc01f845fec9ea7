#pragma once
// What an FMU simulates, without the interface of a version of FMI.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/fmu/unit/constants.hpp"
#include "host-sim/fmu/unit/variables.hpp"

namespace smaservo::fmu::unit {

/// A longer step would take minutes.
constexpr double longest_step_s = 1e5;

class Component {
 public:
  virtual ~Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  /// Checks the parameters and inputs, and begins anew, at rest. Returns what is wrong, or "";
  /// after an error nothing has changed.
  virtual std::string begin() = 0;
  /// Goes on to `to_s`, seconds since the beginning; the step is `step_s` long. Returns what is
  /// wrong, or ""; after an error nothing has changed.
  virtual std::string advance(double to_s, double step_s) = 0;
  /// All that the component remembers beside `values`: bytes that may be copied away and back.
  virtual std::span<std::byte> memory() = 0;
  /// Computes what follows from the parameters, after `values` and memory() were copied back.
  virtual void restored() {}

  const std::vector<Variable>& variables() const { return variables_; }
  /// By value reference.
  std::vector<double> values;

 protected:
  Component(std::vector<Variable> variables, std::vector<double> start)
      : values(std::move(start)), variables_(std::move(variables)) {}

 private:
  std::vector<Variable> variables_;
};

/// The values of parameters and inputs, which are taken out of the constants; the others are 0.
/// Throws ConstantsError.
inline std::vector<double> start_values(const std::vector<Variable>& variables,
                                        Constants& constants) {
  std::vector<double> values;
  for (const Variable& v : variables) {
    const bool given = v.role == Role::parameter || v.role == Role::input;
    values.push_back(given ? constants.take(v.name) : 0);
  }
  return values;
}

/// Of the kind that the library is for: wire.cpp or servo.cpp. Throws ConstantsError.
std::unique_ptr<Component> make_component(Constants& constants);
/// Its name, "wire" or "servo".
const char* component_kind();

}  // namespace smaservo::fmu::unit
