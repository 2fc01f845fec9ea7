#pragma once
// The board file: which devices a Linux board has, and what their codes mean. README.md has the
// keys, hal/linux/boards/ has examples.

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "firmware/canopen/servo/servo_core.hpp"
#include "firmware/daemon/process/realtime.hpp"
#include "firmware/settings.hpp"
#include "hal/linux/board.hpp"
#include "hal/linux/devices/ads131m04_digitizer.hpp"
#include "hal/linux/devices/iio.hpp"

namespace smaservo::daemon {

struct Ads131m04FrontEnd {
  hal::SpiSettings spi;
  hal::Ads131m04Settings settings;
};

struct BusSettings {
  std::string interface;  ///< "can0", or "udp", "udp:GROUP", "udp:GROUP:PORT"
  unsigned node_id;       ///< 0: the settings' node-id
  double lost_after_s;    ///< time without a frame that raises bus_lost; 0: never
  canopen::AccessKeys keys;
  bool unattended;  ///< heat may go on without anybody who commands
};

struct BoardFile {
  std::string name;
  std::string device;  ///< settings file
  std::string folder;  ///< folder of the store
  RealTimeSettings thread;
  canopen::Ceilings ceilings;  ///< the current's is at most drive.max_mA
  std::variant<Ads131m04FrontEnd, hal::IioSettings> front_end;
  hal::Calibration calibration;
  std::array<hal::SlowSensor, hal::SlowSensors::count> slow;
  std::variant<hal::IioDacSettings, hal::SpiDacSettings, hal::PwmSettings> drive;
  hal::LinesSettings lines;
  std::optional<BusSettings> bus;
  std::string text;  ///< the whole file
};

/// Folder of the store, unless the board file names another one.
inline constexpr const char* default_folder = "/var/lib/smaservo";

/// Throws ConfigError, which names file, line, key, value and what is allowed.
BoardFile load_board_file(const std::string& path);

/// Both open the device that the file names, and throw DeviceError.
std::unique_ptr<hal::Digitizer> open_front_end(const BoardFile& file, const hal::LinuxRoots& roots);
std::unique_ptr<hal::OutputStage> open_drive(const BoardFile& file, const hal::LinuxRoots& roots);

/// Whether the board writes to this device of the kernel: a name in /sys, such as "spidev0.0",
/// "iio:device0", "trigger0", "gpiochip0" or "pwmchip0".
bool drives(const BoardFile& file, const hal::LinuxRoots& roots, const std::string& device);

/// timing.period_s on a board: 100 Hz to 2 kHz.
inline constexpr double shortest_period_s = 0.5e-3, longest_period_s = 10e-3;
/// What is wrong with the period of these settings; empty: nothing.
std::string period_problem(const Settings<double>& settings);

/// Why these settings are beyond the board; empty: they are not.
std::string board_problem(const BoardFile& file, const Settings<double>& settings);

}  // namespace smaservo::daemon
