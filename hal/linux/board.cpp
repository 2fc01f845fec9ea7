#include "hal/linux/board.hpp"

#include <limits>
#include <utility>

#include "hal/linux/system/clock.hpp"

namespace smaservo::hal {
namespace {

double reading(const Channel& channel, const RawFrame& raw) {
  return (static_cast<double>(raw.codes.at(channel.place)) - channel.zero_code) * channel.scale;
}

}  // namespace

void apply(const Calibration& calibration, const RawFrame& raw, Frame& frame) {
  frame.current_A = reading(calibration.current, raw);
  frame.voltage_V = reading(calibration.voltage, raw);
  frame.load_N = calibration.has_load ? reading(calibration.load, raw)
                                      : std::numeric_limits<double>::quiet_NaN();
}

LinuxBoard::LinuxBoard(LinuxBoardParts parts)
    : parts_(std::move(parts)), off_(parts_.lines->off_actions()) {
  off_.push_back(parts_.drive->off_action());
  safe_off();
}

LinuxBoard::~LinuxBoard() {
  safe_off();
}

ReadStatus LinuxBoard::read(Frame& frame) {
  const bool came = parts_.digitizer->read(raw_);
  stopped_ = parts_.lines->emergency_stop();
  frame.emergency_stop = stopped_;
  frame.driver_fault = parts_.lines->driver_fault() || drive_failed_;
  if (!came) {
    frame.time_ns = monotonic_ns();
    return ReadStatus::nothing;
  }
  frame.time_ns = raw_.time_ns;
  frame.sequence = raw_.sequence;
  apply(parts_.calibration, raw_, frame);
  frame.supply_V = parts_.slow->value(SlowSensors::supply);
  frame.ambient_K = parts_.slow->value(SlowSensors::ambient);
  frame.driver_K = parts_.slow->value(SlowSensors::driver);
  return ReadStatus::frame;
}

void LinuxBoard::drive(const DriveCommand& command) {
  // The emergency stop switches off at once, before a frame tells the device of it.
  if (stopped_) {
    safe_off();
    return;
  }
  const bool on = command.current_A > 0 || command.voltage_V > 0;
  // To switch on, the command is given before the switch closes; to switch off, the switch opens
  // first.
  bool taken = true;
  if (!on && enabled_) {
    taken = parts_.lines->enable(false);
    enabled_ = !taken;
  }
  taken = parts_.drive->put(command) && taken;
  if (on && taken && !enabled_) {
    taken = enabled_ = parts_.lines->enable(true);
  }
  drive_failed_ = !taken;
  if (drive_failed_) {
    safe_off();
  }
}

void LinuxBoard::safe_off() {
  parts_.lines->enable(false);
  parts_.drive->off();
  enabled_ = false;
}

void LinuxBoard::kick() {
  if (!stopped_ && !drive_failed_ && !parts_.lines->kick()) {
    drive_failed_ = true;
  }
}

std::int64_t LinuxBoard::now_ns() {
  return monotonic_ns();
}

}  // namespace smaservo::hal
