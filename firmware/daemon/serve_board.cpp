#include "firmware/daemon/serve.hpp"
#include "host-sim/output_file.hpp"

namespace smaservo {

int serve_board(const DaemonOptions& options) {
  throw UserError(options.board + ": boards of Linux come with the next release");
}
int check_board(const DaemonOptions& options) {
  return serve_board(options);
}
int switch_board_off(const DaemonOptions& options) {
  return serve_board(options);
}

}  // namespace smaservo
