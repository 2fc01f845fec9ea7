#pragma once
// A recorded trace as the daemon's board and command source.

#include <string>
#include <string_view>
#include <vector>

#include "firmware/daemon/loop/command_source.hpp"
#include "firmware/daemon/loop/desk.hpp"
#include "firmware/text/device_log.hpp"
#include "hal/replay/board.hpp"

namespace smaservo::daemon {

/// Time, commands and changes of parameters come from the trace. The loop allocates memory, so this
/// is no board for real-time use.
class Replaying : public CommandSource {
 public:
  static constexpr bool in_monotonic_time = false;

  /// Throws TraceError, UserError.
  Replaying(const std::string& trace, const Settings<double>& settings, ParameterDesk& desk);

  // The members that hal::Board requires.
  hal::ReadStatus read(hal::Frame& frame) { return board_.read(frame); }
  void drive(const hal::DriveCommand& command) { board_.drive(command); }
  void safe_off() { board_.safe_off(); }
  void kick() { board_.kick(); }
  std::int64_t now_ns() const { return board_.now_ns(); }

  // The member that CommandSource requires.
  Heard<double> listen(double time_s) override;

 private:
  std::string name_;
  ParameterDesk& desk_;
  hal::ReplayBoard board_;
  text::DeviceLog log_;
  std::vector<std::string_view> fields_;
};

static_assert(hal::Board<Replaying>);

}  // namespace smaservo::daemon
