#pragma once
// The strain controllers that the table compares.

#include <array>
#include <memory>
#include <string_view>

#include "firmware/device/device.hpp"
#include "host-sim/evaluate/closed_loop/loop_bench.hpp"
#include "observer/papers/strain_resistance.hpp"

namespace smaservo::evaluate {

enum class LoopKind : unsigned char {
  device,       ///< the firmware
  ideal,        ///< the firmware with the true strain instead of its estimate
  resistance,   ///< the firmware's resistance mode, with a straight line from strain to resistance
  position_002  ///< paper 002: its estimator and a PID from strain to current
};
inline constexpr std::array loop_kinds{LoopKind::device, LoopKind::ideal, LoopKind::resistance,
                                       LoopKind::position_002};
std::string_view loop_kind_name(LoopKind kind);

class LoopController {
 public:
  virtual ~LoopController() = default;
  /// Makes one step: returns the current that brings the wire to this strain.
  virtual double current_A(const Inputs<double>& in, double goal, double true_strain) = 0;
  /// The fault for which the controller has switched off; Fault::none while it runs.
  virtual Fault tripped() const { return Fault::none; }
};

/// A unit, its calibrated wire, and paper 002's estimator, identified from the same runs.
struct KnownUnit {
  bench::WireUnit unit;
  Wire<double> wire;
  papers::StrainResistance<double>::Params estimator_002;
};
/// Calibrates the wire or reads it from the folder. 002's estimator is identified each time, which
/// takes 3 s.
KnownUnit known_unit(hal::Family family, std::uint64_t seed, const std::string& folder);

std::unique_ptr<LoopController> make_loop(LoopKind kind, const KnownUnit& known);

/// The firmware's step as a controller; accepts any command.
class DeviceLoop {
 public:
  explicit DeviceLoop(const Settings<double>& settings);
  /// `true_strain`, unless it is NaN, replaces the estimate.
  const Output<double>& step(const Inputs<double>& in, const Command<double>& command,
                             double true_strain);
  const Output<double>& output() const { return output_; }

 private:
  Prepared<double> prepared_;
  Device<double>::State state_;
  Output<double> output_{};
};

}  // namespace smaservo::evaluate
