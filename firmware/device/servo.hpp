#pragma once
// The whole device as an object: readings and a set-point in, the current for the wire out.
//
//   Servo servo{settings};
//   for (;;) {  // each settings.timing.period_s
//     const auto out = servo.update(read(), {.mode = Mode::strain, .setpoint = 0.03}, dt_s);
//     drive(out.drive_current_A);
//   }
//
// What drives the current must end it by itself when this loop hangs: firmware/SAFETY.md.

#include <limits>
#include <type_traits>

#include "firmware/device/device.hpp"
#include "firmware/prepared.hpp"
#include "model/scalar/scalar.hpp"

namespace smaservo {

/// Measures, observes, protects and controls, as smaservod does. Trivially copyable: a copy is a
/// saved state. No heap, no exceptions. On a PC in double a step costs 0.4 us, and the object takes
/// 13 kB (7 kB in float).
template <class S>
class Servo {
 public:
  /// Settings that check() of firmware/parameters/parameter_check.hpp has passed, as
  /// load_settings_file() gives them: their numbers are not checked again.
  explicit Servo(const Settings<S>& settings) : prepared_(prepare(settings)) {}

  /// One period: dt_s since the last call, about settings.timing.period_s (0.1 to 20 ms). After
  /// more than three periods the device reports loop_stalled and gives no current. A reading that
  /// is NaN is a sensor that has failed, and ends heat. Any mode but Mode::off asks to run: the
  /// device then arms itself, which takes some tenths of a second, unless Output::blocks says what
  /// is in the way. `fresh` and `arm` of the command are not looked at. A set-point that is not
  /// allowed is limited; Output::setpoint is what is in force. A dt_s that is not greater than 0
  /// makes no step and gives no current.
  Output<S> update(const Sample<S>& reading, Command<S> command, const S& dt_s) {
    constexpr S nan = std::numeric_limits<S>::quiet_NaN();
    Inputs<S> in{};
    in.fresh = true;
    in.sequence = ++sequence_;
    in.sample = reading;
    in.supply_V = in.ambient_K = in.driver_K = nan;
    command.fresh = true;
    command.arm = command.mode != Mode::off;
    return step(in, command, dt_s);
  }

  /// The same for a board with more to tell: emergency stop, supply, air, faults, a reading that
  /// has not come in this period (Inputs), and a command from elsewhere that may have ceased to
  /// come (Command::fresh).
  Output<S> step(const Inputs<S>& in, const Command<S>& command, const S& dt_s) {
    if (!(S(0) < dt_s)) {
      Output<S> none = state_.last;
      none.drive_current_A = none.drive_voltage_V = S(0);
      return none;
    }
    return Device<S>::step(prepared_, state_, in, command, dt_s);
  }

  /// As given to the constructor.
  const Settings<S>& settings() const { return prepared_.settings; }
  /// The output of the last step that was made, all zero before the first: for looking, not for the
  /// drive, which gets what update() returns.
  const Output<S>& last() const { return state_.last; }

 private:
  Prepared<S> prepared_;
  typename Device<S>::State state_ = Device<S>::start();
  std::uint32_t sequence_ = 0;
};

static_assert(std::is_trivially_copyable_v<Servo<double>>);

}  // namespace smaservo
