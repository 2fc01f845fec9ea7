#pragma once
// A step of the position to a target and back, started over CAN (2400h), with the figures of the
// response; it triggers the recorder.

#include "firmware/canopen/servo/axis.hpp"
#include "firmware/canopen/servo/recorder.hpp"

namespace smaservo::canopen {

class StepTest {
 public:
  enum class State : std::uint8_t { none, running, done, broken_off };

  explicit StepTest(DriveObjects& objects) : o_(objects) {}

  void reset();
  /// Carries out a write to 2400h:1.
  Abort command(std::uint8_t command, Axis& axis, Recorder& recorder);
  /// To be called once per step of the loop.
  void step(const Signals& signals, float dt_s, Axis& axis);

 private:
  State state() const { return static_cast<State>(o_.step_state); }
  void end(State state) { o_.step_state = static_cast<std::uint8_t>(state); }
  void look(float share);

  DriveObjects& o_;
  std::int32_t base_um_ = 0, target_um_ = 0;
  float time_s_ = 0, rise_from_s_ = 0;
  float error_sum_um_ = 0;
  std::uint32_t error_count_ = 0;
  bool rose_from_ = false, rose_to_ = false, back_ = false;
};

}  // namespace smaservo::canopen
