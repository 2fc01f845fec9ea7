#pragma once
// Records chosen signals at the rate of the loop, around a trigger, into a buffer that the main
// program provides; read by block upload of 2300h:11. Cost: 8 copies and a comparison per step.

#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/signals.hpp"

namespace smaservo::canopen {

class Recorder {
 public:
  enum class State : std::uint8_t { idle, armed, triggered, full };

  Recorder(DriveObjects& objects, std::span<float> buffer) : o_(objects), buffer_(buffer) {}

  void reset(float step_s);
  /// Carries out a write to 2300h:1.
  Abort command(std::uint8_t command);
  static Abort check_channel(std::uint32_t sub) {
    return sub <= signal_count ? Abort::none : Abort::value;
  }
  void trigger();
  /// To be called once per step of the loop.
  void record(const Signals& signals);

  State state() const { return static_cast<State>(o_.recorder_state); }
  /// The number of bytes that can be read now.
  std::uint32_t size() const;
  Abort read(std::uint32_t offset, std::span<std::uint8_t> to) const;

 private:
  Abort arm();
  bool crosses(float value);
  void keep(const Signals& signals);

  DriveObjects& o_;
  std::span<float> buffer_;
  float step_s_ = 0;
  std::array<std::uint8_t, channel_count> channels_{};
  std::size_t width_ = 0;  ///< channels per row
  std::size_t rows_ = 0;   ///< rows for which the buffer has room
  std::size_t next_ = 0, left_ = 0;
  std::uint16_t steps_ = 0;
  float before_ = 0;
  bool has_before_ = false;
};

}  // namespace smaservo::canopen
