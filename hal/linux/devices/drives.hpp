#pragma once
// Output stages, which carry out the drive command. They keep their value if it is not written
// again, so the hardware's one-shot must enforce the lease: see firmware/HARDWARE.md.

#include <array>
#include <memory>
#include <string>

#include "hal/board.hpp"
#include "hal/linux/devices/spi.hpp"
#include "hal/linux/system/files.hpp"
#include "hal/linux/system/off_action.hpp"

namespace smaservo::hal {

class OutputStage {
 public:
  OutputStage() = default;
  virtual ~OutputStage() = default;
  OutputStage(const OutputStage&) = delete;
  OutputStage& operator=(const OutputStage&) = delete;

  /// Outputs a command; false if it was not accepted. One system call, no allocation.
  virtual bool put(const DriveCommand& command) = 0;
  /// Switches off; false if that failed.
  virtual bool off() = 0;
  /// The system call of off(), for a signal handler. The result is valid as long as the stage
  /// lives.
  virtual OffAction off_action() = 0;
};

/// How a command is converted to a converter's code, which is bounded by 0 and max_code.
struct DacScale {
  double codes_per_unit;  ///< codes per ampere, or per volt if the drive takes a voltage
  double zero_code = 0;   ///< code at which there is no output
  double max_code = 65535;
  bool voltage = false;  ///< uses DriveCommand::voltage_V instead of current_A
};
/// The code for a command; NaN switches off.
std::int64_t dac_code(const DacScale& scale, const DriveCommand& command);

struct IioDacSettings {
  std::string device;  ///< value of its attribute `name`
  std::string channel = "out_voltage0";
  DacScale scale;
};

class IioDac final : public OutputStage {
 public:
  IioDac(const LinuxRoots& roots, const IioDacSettings& settings);
  bool put(const DriveCommand& command) override;
  bool off() override { return put_number(file_.number(), dac_code(scale_, {})); }
  OffAction off_action() override;

 private:
  DacScale scale_;
  Descriptor file_;
  std::string off_;
};

struct SpiDacSettings {
  SpiSettings spi;
  /// 2 or 3 bytes, the most significant one first; the code is in the lowest bits, shifted by
  /// `shift`.
  unsigned frame_bytes = 3;
  std::uint32_t command = 0;  ///< bits above the code, already at their position
  unsigned shift = 0;         ///< number of bits by which the code is shifted to the left
  DacScale scale;
};

/// The bytes that are sent for a code.
std::array<std::uint8_t, 3> dac_frame(const SpiDacSettings& settings, std::int64_t code);

class SpiDac final : public OutputStage {
 public:
  /// `port` null: opens the device of the settings. Tests give a port of their own.
  SpiDac(const LinuxRoots& roots, const SpiDacSettings& settings,
         std::unique_ptr<SpiPort> port = nullptr);
  ~SpiDac() override;
  SpiDac(const SpiDac&) = delete;
  SpiDac& operator=(const SpiDac&) = delete;
  bool put(const DriveCommand& command) override;
  bool off() override { return put({}); }
  OffAction off_action() override;

 private:
  struct OffTransfer;

  SpiDacSettings settings_;
  std::unique_ptr<SpiPort> port_;
  std::unique_ptr<OffTransfer> off_;
  int descriptor_ = -1;
};

struct PwmSettings {
  std::string chip = "pwmchip0";
  unsigned channel = 0;
  std::int64_t period_ns = 50'000;
  double supply_V = 24;  ///< the duty cycle is the commanded voltage over supply_V
  double max_duty = 0.95;
};

/// A PWM output of the kernel, through sysfs; the file of the duty cycle stays open.
class PwmDrive final : public OutputStage {
 public:
  PwmDrive(const LinuxRoots& roots, const PwmSettings& settings);
  bool put(const DriveCommand& command) override;
  bool off() override { return put_number(duty_.number(), 0); }
  OffAction off_action() override;

 private:
  PwmSettings settings_;
  Descriptor duty_;
  char zero_ = '0';
};

}  // namespace smaservo::hal
