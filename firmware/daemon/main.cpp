// The firmware on a Linux board.

#include <exception>
#include <sysexits.h>

#include "firmware/daemon/serve.hpp"
#include "hal/linux/can/can_status.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/wire/wire_file.hpp"

namespace {

int run(const smaservo::daemon::DaemonOptions& options) {
  if (options.board == "sim" || options.board.starts_with("sim=")) {
    return options.check ? smaservo::daemon::check_simulation(options)
                         : smaservo::daemon::serve_simulation(options);
  }
  if (options.board.starts_with("replay=")) {
    return options.check ? smaservo::daemon::check_replay(options)
                         : smaservo::daemon::serve_replay(options);
  }
  if (!options.owns.empty()) {
    return smaservo::daemon::tell_owned(options);
  }
  if (options.off) {
    return smaservo::daemon::switch_board_off(options);
  }
  return options.check ? smaservo::daemon::check_board(options)
                       : smaservo::daemon::serve_board(options);
}

int ended_by(const std::exception& error, int code) {
  smaservo::files::complain("smaservod", error.what());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  smaservo::files::hold_standard_descriptors();
  smaservo::daemon::DaemonOptions options;
  int code = 0;
  if (!smaservo::daemon::parse_options(argc, argv, options, code)) {
    return code;
  }
  try {
    code = run(options);
    while (code == smaservo::daemon::start_anew) {
      smaservo::daemon::prepare_next_run(options);
      code = run(options);
    }
    return code;
  } catch (const smaservo::files::ConfigError& error) {
    return ended_by(error, EX_CONFIG);
  } catch (const smaservo::hal::CanNameError& error) {
    return ended_by(error, EX_CONFIG);
  } catch (const std::exception& error) {
    return ended_by(error, 1);
  }
}
