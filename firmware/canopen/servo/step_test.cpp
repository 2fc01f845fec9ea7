#include "firmware/canopen/servo/step_test.hpp"

#include <cmath>
#include <limits>

namespace smaservo::canopen {
namespace {

// Places in DriveObjects::figures.
constexpr std::size_t rise = 0, overshoot = 1, settling = 2, error_m = 3, peak_K = 4;

}  // namespace

void StepTest::reset() {
  end(State::none);
}

Abort StepTest::command(std::uint8_t command, Axis& axis, Recorder& recorder) {
  if (command == 0) {
    if (state() == State::running) {
      axis.go_to(base_um_);
      end(State::broken_off);
    }
    return Abort::none;
  }
  const bool possible = axis.is_enabled() && state() != State::running &&
                        o_.mode_display == static_cast<std::int8_t>(DriveMode::profile_position);
  if (!possible) {
    return Abort::state;
  }
  if (o_.amplitude_um == 0 || std::abs(std::int64_t{o_.amplitude_um}) > 1'000'000) {
    return Abort::value;
  }
  base_um_ = o_.actual;
  target_um_ = base_um_ + o_.amplitude_um;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  o_.figures = {nan, 0, 0, nan, 0};
  time_s_ = rise_from_s_ = error_sum_um_ = 0;
  error_count_ = 0;
  rose_from_ = rose_to_ = back_ = false;
  recorder.trigger();
  axis.go_to(target_um_);
  end(State::running);
  return Abort::none;
}

void StepTest::step(const Signals& signals, float dt_s, Axis& axis) {
  if (state() != State::running) {
    return;
  }
  if (!axis.is_enabled() || axis.moves_to() != (back_ ? base_um_ : target_um_)) {
    end(State::broken_off);
    return;
  }
  time_s_ += dt_s;
  const float duration_s = 1e-3F * static_cast<float>(o_.step_ms);
  o_.figures[peak_K] = std::fmax(o_.figures[peak_K], signals[signal_index("wire_temperature_K")]);
  if (back_) {
    if (duration_s <= time_s_) {
      end(State::done);
    }
    return;
  }
  look(static_cast<float>(o_.actual - base_um_) / static_cast<float>(o_.amplitude_um));
  if (duration_s <= time_s_) {
    o_.figures[error_m] = 1e-6F * error_sum_um_ / static_cast<float>(error_count_);
    time_s_ = 0;
    back_ = true;
    axis.go_to(base_um_);
  }
}

/// Updates the figures. `share` is the part of the amplitude that the wire has covered.
void StepTest::look(float share) {
  constexpr float band = 0.05F;
  if (!rose_from_ && 0.1F <= share) {
    rose_from_ = true;
    rise_from_s_ = time_s_;
  }
  if (!rose_to_ && 0.9F <= share) {
    rose_to_ = true;
    o_.figures[rise] = time_s_ - rise_from_s_;
  }
  o_.figures[overshoot] = std::fmax(o_.figures[overshoot], share - 1.F);
  if (band < std::fabs(share - 1.F)) {
    o_.figures[settling] = time_s_;
  }
  if (0.75e-3F * static_cast<float>(o_.step_ms) <= time_s_) {
    error_sum_um_ += static_cast<float>(target_um_ - o_.actual);
    ++error_count_;
  }
}

}  // namespace smaservo::canopen
