#include "firmware/canopen/servo/recorder.hpp"

namespace smaservo::canopen {

void Recorder::reset(float step_s) {
  step_s_ = step_s;
  o_.recorder_state = static_cast<std::uint8_t>(State::idle);
  o_.samples = 0;
  width_ = rows_ = 0;
}

Abort Recorder::command(std::uint8_t command) {
  constexpr std::uint8_t arm_it = 1, trigger_it = 2;
  if (command == arm_it) {
    return arm();
  }
  if (command == trigger_it) {
    if (state() != State::armed) {
      return Abort::state;
    }
    trigger();
  } else {
    o_.recorder_state = static_cast<std::uint8_t>(State::idle);
  }
  return Abort::none;
}

/// Records the channels that are chosen now, whatever is written to 2301h later.
Abort Recorder::arm() {
  width_ = 0;
  for (const std::uint8_t channel : o_.channels) {
    if (channel != 0) {
      channels_[width_++] = channel;
    }
  }
  rows_ = width_ == 0 ? 0 : buffer_.size() / width_;
  o_.capacity = static_cast<std::uint32_t>(rows_);
  o_.samples = 0;
  if (rows_ == 0 || rows_ <= o_.pretrigger) {
    rows_ = 0;
    o_.recorder_state = static_cast<std::uint8_t>(State::idle);
    return Abort::incompatible;
  }
  next_ = 0;
  steps_ = 0;
  has_before_ = false;
  o_.sample_period_s = step_s_ * static_cast<float>(o_.divisor);
  o_.recorder_state = static_cast<std::uint8_t>(State::armed);
  return Abort::none;
}

void Recorder::trigger() {
  if (state() == State::armed) {
    o_.recorder_state = static_cast<std::uint8_t>(State::triggered);
    left_ = rows_ - o_.pretrigger;
  }
}

bool Recorder::crosses(float value) {
  const float level = o_.level_value;
  const bool rises = has_before_ && before_ < level && level <= value;
  const bool falls = has_before_ && level <= before_ && value < level;
  before_ = value;
  has_before_ = true;
  constexpr std::uint8_t rising = 0, falling = 1;
  return o_.trigger_edge == rising ? rises : o_.trigger_edge == falling ? falls : rises || falls;
}

void Recorder::record(const Signals& signals) {
  if (state() != State::armed && state() != State::triggered) {
    return;
  }
  // A trigger counts only when enough samples for the pretrigger have been recorded.
  if (state() == State::armed) {
    const bool crossed =
        o_.trigger_signal == 0 || crosses(signals[o_.trigger_signal - std::size_t{1}]);
    if (crossed && o_.pretrigger <= o_.samples) {
      trigger();
    }
  }
  if (steps_ == 0) {
    keep(signals);
  }
  steps_ = steps_ + 1U >= o_.divisor ? std::uint16_t{0} : static_cast<std::uint16_t>(steps_ + 1);
}

void Recorder::keep(const Signals& signals) {
  const std::span<float> row = buffer_.subspan(next_ * width_, width_);
  for (std::size_t i = 0; i < width_; ++i) {
    row[i] = signals[channels_[i] - std::size_t{1}];
  }
  next_ = next_ + 1 == rows_ ? 0 : next_ + 1;
  o_.samples = o_.samples < rows_ ? o_.samples + 1 : o_.samples;
  if (state() == State::triggered && --left_ == 0) {
    o_.recorder_state = static_cast<std::uint8_t>(State::full);
  }
}

std::uint32_t Recorder::size() const {
  const bool stands = state() == State::idle || state() == State::full;
  return stands && rows_ != 0 ? static_cast<std::uint32_t>(4 * width_) * o_.samples : 0;
}

Abort Recorder::read(std::uint32_t offset, std::span<std::uint8_t> to) const {
  if (state() == State::armed || state() == State::triggered) {
    return Abort::state;
  }
  if (size() == 0) {
    return Abort::no_data;
  }
  const std::size_t first = (next_ + rows_ - o_.samples) % rows_ * width_;
  const std::size_t all = rows_ * width_;
  for (std::uint8_t& byte : to) {
    const std::uint32_t bits = as_bits(buffer_[(first + offset / 4) % all]);
    byte = static_cast<std::uint8_t>(bits >> 8U * (offset % 4));
    ++offset;
  }
  return Abort::none;
}

}  // namespace smaservo::canopen
