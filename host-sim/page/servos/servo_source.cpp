#include "host-sim/page/servos/servo_source.hpp"

#include "model/files/error.hpp"

namespace smaservo::page {

std::unique_ptr<Source> make_servo_source(const ServoOptions& options) {
  throw files::UserError("--can " + options.can + ": this build has no source for servos");
}

}  // namespace smaservo::page
