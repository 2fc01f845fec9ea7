#pragma once
// An instance of an FMU, as both versions of FMI need it: its states, its values, its saved states.
// Each function returns what is wrong, or ""; after an error nothing has changed.

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host-sim/fmu/unit/component.hpp"

namespace smaservo::fmu::unit {

enum class Stage : std::uint32_t { instantiated, initializing, running, terminated };

/// A saved state: a header, the values, the component's memory, a checksum.
using Saved = std::vector<unsigned char>;

class Instance {
 public:
  /// `location`: of the resources, a path or a URI. Throws ConstantsError.
  Instance(const std::string& token, const std::string& location);

  std::string enter_initialization(double start_s);
  std::string exit_initialization();
  std::string terminate();
  std::string start_over();
  /// From the present time, which the caller says, for so long.
  std::string step(double from_s, double step_s);

  /// Whether a value of this type may be set or read: a choice is a whole number, too, where
  /// `choice_is_whole`.
  std::string get(std::size_t reference, Type type, bool choice_is_whole, double& value);
  /// Sets all of them or none.
  std::string set(const std::vector<std::size_t>& references, Type type, bool choice_is_whole,
                  const std::vector<double>& values);

  Saved save();
  std::string restore(const Saved& saved);
  /// Whether these bytes are a saved state of this FMU.
  std::string check(const Saved& saved) const;

  double time_s() const { return component_->values[0]; }
  Stage stage() const { return stage_; }

 private:
  std::string wrong_reference(std::size_t reference, Type type, bool choice_is_whole) const;
  std::string refresh();

  std::unique_ptr<Component> component_;
  std::vector<double> start_;  ///< values after instantiation
  std::uint64_t identity_;     ///< of the description
  Stage stage_ = Stage::instantiated;
  double start_s_ = 0;
  bool stale_ = true;  ///< outputs of initialization do not follow from the values
};

}  // namespace smaservo::fmu::unit
