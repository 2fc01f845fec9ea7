#pragma once
// The board file: the devices of a Linux board and the meaning of their codes. README.md has the
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
  unsigned node_id;       ///< 0: the node-id of the settings
  double lost_after_s;    ///< time without a frame after which bus_lost is raised; 0: never
  canopen::AccessKeys keys;
  bool unattended;  ///< heat may continue without a command source
};

struct BoardFile {
  std::string name;
  std::string device;  ///< settings file
  std::string folder;  ///< folder of the store
  RealTimeSettings thread;
  canopen::Ceilings ceilings;  ///< the ceiling of the current is at most drive.max_mA
  std::variant<Ads131m04FrontEnd, hal::IioSettings> front_end;
  hal::Calibration calibration;
  std::array<hal::SlowSensor, hal::SlowSensors::count> slow;
  std::variant<hal::IioDacSettings, hal::SpiDacSettings, hal::PwmSettings> drive;
  hal::LinesSettings lines;
  std::optional<BusSettings> bus;
  std::string text;  ///< the whole file
};

/// The store's folder if the board file does not name another one.
inline constexpr const char* default_folder = "/var/lib/smaservo";

/// Throws ConfigError, which names file, line, key, value and what is allowed.
BoardFile load_board_file(const std::string& path);

/// These two functions open the device that the file names, and throw DeviceError.
std::unique_ptr<hal::Digitizer> open_front_end(const BoardFile& file, const hal::LinuxRoots& roots);
std::unique_ptr<hal::OutputStage> open_drive(const BoardFile& file, const hal::LinuxRoots& roots);

/// Whether the board writes to this device of the kernel, given by its name in /sys, such as
/// "spidev0.0", "iio:device0", "trigger0", "gpiochip0" or "pwmchip0".
bool drives(const BoardFile& file, const hal::LinuxRoots& roots, const std::string& device);

/// Range of timing.period_s on a board: 100 Hz to 2 kHz.
inline constexpr double shortest_period_s = 0.5e-3, longest_period_s = 10e-3;
/// The reason why the period of these settings is not possible; empty if it is possible.
std::string period_problem(const Settings<double>& settings);

/// The reason why the board cannot use these settings; empty if it can.
std::string board_problem(const BoardFile& file, const Settings<double>& settings);

}  // namespace smaservo::daemon
