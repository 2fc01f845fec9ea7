// The firmware on a Linux board.

#include <cstdio>
#include <exception>

#include "firmware/daemon/serve.hpp"

namespace {

int run(const smaservo::DaemonOptions& options) {
  if (options.board == "sim" || options.board.starts_with("sim=")) {
    return smaservo::serve_simulation(options);
  }
  if (options.board.starts_with("replay=")) {
    return smaservo::serve_replay(options);
  }
  if (options.off) {
    return smaservo::switch_board_off(options);
  }
  return options.check ? smaservo::check_board(options) : smaservo::serve_board(options);
}

}  // namespace

int main(int argc, char** argv) {
  smaservo::DaemonOptions options;
  int code = 0;
  if (!smaservo::parse_options(argc, argv, options, code)) {
    return code;
  }
  try {
    code = run(options);
    while (code == smaservo::start_anew) {
      smaservo::prepare_next_run(options);
      code = run(options);
    }
    return code;
  } catch (const std::exception& error) {
    std::fputs("smaservod: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
  }
  return 1;
}
