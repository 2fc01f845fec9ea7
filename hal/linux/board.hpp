#pragma once
// A board of Linux devices: which ones, says its setup.

#include <array>
#include <memory>
#include <vector>

#include "hal/board.hpp"
#include "hal/linux/devices/digitizer.hpp"
#include "hal/linux/devices/drives.hpp"
#include "hal/linux/devices/lines.hpp"
#include "hal/linux/devices/slow_sensors.hpp"

namespace smaservo::hal {

/// A reading from a code: SI is (code - zero_code) * scale. A code at or beyond its bounds is that
/// of a converter at its rail and stays what it is: the device knows its full scale.
struct Channel {
  std::size_t place;  ///< in the raw frame
  double scale;       ///< SI by code
  double zero_code = 0;
};

struct Calibration {
  Channel current, voltage;
  bool has_load = false;
  Channel load{};
};

/// The readings that a raw frame means; the rest of the frame stays.
void apply(const Calibration& calibration, const RawFrame& raw, Frame& frame);

struct LinuxBoardParts {
  std::unique_ptr<Digitizer> digitizer;
  std::unique_ptr<OutputStage> drive;
  std::unique_ptr<Lines> lines;
  std::unique_ptr<SlowSensors> slow;
  Calibration calibration;
};

/// What fails in operation becomes part of the frames: no frame, or a driver fault. The loop's
/// calls allocate nothing.
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
  /// None after a command that the drive did not take.
  void kick();
  static std::int64_t now_ns();

  /// Valid as long as the board.
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
