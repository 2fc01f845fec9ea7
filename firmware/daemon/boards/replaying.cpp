#include "firmware/daemon/boards/replaying.hpp"

#include <limits>

namespace smaservo::daemon {
namespace {

hal::TraceOptions of_a_device() {
  hal::TraceOptions options;
  options.device = true;
  return options;
}

}  // namespace

Replaying::Replaying(const std::string& trace, const Settings<double>& settings,
                     ParameterDesk& desk)
    : name_(trace),
      desk_(desk),
      board_(hal::TraceReader(trace, of_a_device()), std::numeric_limits<double>::quiet_NaN(),
             settings.wire.geometry.area_m2()),
      log_(name_, board_.trace().names()) {}

Heard<double> Replaying::listen(double time_s) {
  text::split_fields(board_.row().text, fields_);
  Settings<double> settings = desk_.copy();
  if (log_.change(fields_, time_s, settings)) {
    desk_.change(settings);
  }
  return log_.heard(fields_, time_s);
}

}  // namespace smaservo::daemon
