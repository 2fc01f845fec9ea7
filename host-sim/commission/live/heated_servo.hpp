#pragma once
// A servo on the bus that one run heats: it begins only where nobody else does, is watched while it
// is heated, and is left as it was.

#include <memory>
#include <string>

#include "firmware/prepared.hpp"
#include "host-sim/can/bus/recorder.hpp"
#include "host-sim/can/remote.hpp"
#include "host-sim/commission/live/judge.hpp"

namespace smaservo::commission {

/// All functions throw UserError.
class HeatedServo {
 public:
  explicit HeatedServo(can::Remote& remote) : remote_(remote) {}

  /// Reads the settings. Throws unless the servo is disabled, without a fault or anything that
  /// blocks it, obeys commands by SDO, and nobody else has commanded it for `listen_s`.
  void require_free();
  const Prepared<double>& device() const { return *device_; }
  /// As the servo estimated it before any current: the readings of a wire that is not that of the
  /// settings pass for warmer air.
  double ambient_K() const { return ambient_K_; }
  double stress_Pa() { return remote_.number("live.stress_Pa"); }
  /// How long after the last command the device ends its heat by itself.
  double timeout_s() const { return timeout_s_; }

  /// Enables the servo in mode power at the minimum current, and waits until it runs.
  void begin();
  /// Records from now on with the servo's recorder, in the place of what was recorded before; the
  /// first signals are current and voltage.
  void record(const can::RecordingPlan& plan);
  /// `heats`: more than what only measures the resistance.
  void set_power(double power_W, bool heats);
  /// Reads the present values, renews the heat, and throws if the servo has ended it, or somebody
  /// else commands.
  Means look();
  /// The device's names for what limits the heat now.
  std::string limited_by();

  /// Disables the servo and puts mode and set-point back. Does not throw; the text says what became
  /// of the heat, as the end of a message.
  std::string put_back() noexcept;

  can::Remote& remote() { return remote_; }

 private:
  void require_no_other_master();
  void listen_for_others();
  void require_own_command();
  [[noreturn]] void explain_end(unsigned status);
  /// What the recording says of the resistance of a wire that has not been heated.
  std::string recorded_resistance();
  void wait_until_running();

  can::Remote& remote_;
  std::unique_ptr<const Prepared<double>> device_;  ///< null before require_free()
  double ambient_K_ = room_K;
  double timeout_s_ = 5;
  bool begun_ = false;
  std::string mode_, power_text_;  ///< as they were
  double power_W_ = 0;             ///< as commanded
  bool is_cold_ = true;
  can::RecordingPlan recording_;
  std::int64_t checked_us_ = 0;
};

}  // namespace smaservo::commission
