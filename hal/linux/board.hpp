#pragma once
// A board made of the Linux devices that its setup names.

#include <array>
#include <memory>
#include <vector>

#include "hal/board.hpp"
#include "hal/linux/devices/digitizer.hpp"
#include "hal/linux/devices/drives.hpp"
#include "hal/linux/devices/lines.hpp"
#include "hal/linux/devices/slow_sensors.hpp"

namespace smaservo::hal {

/// Converts a code to a reading in SI: (code - zero_code) * scale. Codes at the limit of the
/// converter's range are not treated differently: the device knows the converter's full scale.
struct Channel {
  std::size_t place;  ///< index in the raw frame
  double scale;       ///< SI per code
  double zero_code = 0;
};

struct Calibration {
  Channel current, voltage;
  bool has_load = false;
  Channel load{};
};

/// Writes the readings of a raw frame into `frame`; its other members are left unchanged.
void apply(const Calibration& calibration, const RawFrame& raw, Frame& frame);

struct LinuxBoardParts {
  std::unique_ptr<Digitizer> digitizer;
  std::unique_ptr<OutputStage> drive;
  std::unique_ptr<Lines> lines;
  std::unique_ptr<SlowSensors> slow;
  Calibration calibration;
};

/// A failure in operation shows in the frames: a frame is missing or has a driver fault. Functions
/// that the loop calls allocate nothing.
class LinuxBoard {
 public:
  static constexpr bool in_monotonic_time = true;

  explicit LinuxBoard(LinuxBoardParts parts);
  ~LinuxBoard();
  LinuxBoard(const LinuxBoard&) = delete;
  LinuxBoard& operator=(const LinuxBoard&) = delete;

  ReadStatus read(Frame& frame);
  void drive(const DriveCommand& command);
  void safe_off();
  /// Triggers the one-shot, except after a command that the drive did not accept.
  void kick();
  static std::int64_t now_ns();

  /// The result is valid as long as the board lives.
  std::vector<OffAction> off_actions() const { return off_; }

 private:
  LinuxBoardParts parts_;
  std::vector<OffAction> off_;
  RawFrame raw_{};
  bool stopped_ = false;  ///< the emergency stop is pressed
  bool enabled_ = false;
  bool drive_failed_ = false;
};

static_assert(Board<LinuxBoard>);

}  // namespace smaservo::hal
