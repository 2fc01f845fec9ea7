#pragma once
// What holds a strain in a closed loop, side by side.

#include <array>
#include <memory>
#include <string_view>

#include "firmware/device/device.hpp"
#include "host-sim/evaluate/closed_loop/loop_bench.hpp"
#include "observer/papers/strain_resistance.hpp"

namespace smaservo::evaluate {

enum class LoopKind : unsigned char {
  device,       ///< the firmware
  ideal,        ///< the firmware, whose estimate of the strain is replaced by the truth
  resistance,   ///< the firmware's resistance mode; a straight line from strain to resistance
  position_002  ///< paper 002: its estimator and a PID from strain to current
};
inline constexpr std::array loop_kinds{LoopKind::device, LoopKind::ideal, LoopKind::resistance,
                                       LoopKind::position_002};
std::string_view loop_kind_name(LoopKind kind);

class LoopController {
 public:
  virtual ~LoopController() = default;
  /// One step: the current that brings the wire to this strain.
  virtual double current_A(const Inputs<double>& in, double goal, double true_strain) = 0;
  /// What it has switched off for.
  virtual Fault tripped() const { return Fault::none; }
};

/// What is known of a unit: its calibrated wire, and 002's estimator from the same runs.
struct KnownUnit {
  bench::WireUnit unit;
  Wire<double> wire;
  papers::StrainResistance<double>::Params estimator_002;
};
/// Calibrated, or read from the folder; 002's estimator is identified each time, in 3 s.
KnownUnit known_unit(hal::Family family, std::uint64_t seed, const std::string& folder);

std::unique_ptr<LoopController> make_loop(LoopKind kind, const KnownUnit& known);

/// Any command to the device.
class DeviceLoop {
 public:
  explicit DeviceLoop(const Settings<double>& settings);
  /// With the truth in place of the estimate, where it is a number.
  const Output<double>& step(const Inputs<double>& in, const Command<double>& command,
                             double true_strain);
  const Output<double>& output() const { return output_; }

 private:
  Prepared<double> prepared_;
  Device<double>::State state_;
  Output<double> output_{};
};

}  // namespace smaservo::evaluate
