#pragma once
// What takes the drive command. Outputs keep their value when nobody writes: the lease is the
// hardware's one-shot, see firmware/HARDWARE.md.

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

  /// False: it was not taken. One system call, no allocation.
  virtual bool put(const DriveCommand& command) = 0;
  /// Off; false: that failed.
  virtual bool off() = 0;
  /// The same for a signal handler. Valid as long as the drive.
  virtual OffAction off_action() = 0;
};

/// From a command to a converter's code, bounded on both sides.
struct DacScale {
  double codes_per_unit;  ///< by ampere, or by volt where the drive takes a voltage
  double zero_code = 0;   ///< puts out nothing
  double max_code = 65535;
  bool voltage = false;  ///< takes DriveCommand::voltage_V
};
/// What is no number is off.
std::int64_t dac_code(const DacScale& scale, const DriveCommand& command);

struct IioDacSettings {
  std::string device;  ///< as its attribute `name` says
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
  unsigned frame_bytes = 3;   ///< 2 or 3; the code stands in the lowest bits, first byte first
  std::uint32_t command = 0;  ///< what stands above the code, already in its place
  unsigned shift = 0;         ///< of the code, to the left
  DacScale scale;
};

/// The bytes of a code.
std::array<std::uint8_t, 3> dac_frame(const SpiDacSettings& settings, std::int64_t code);

class SpiDac final : public OutputStage {
 public:
  /// Without a port one is opened; a test brings its own.
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
  double supply_V = 24;  ///< voltage over supply is the duty cycle
  double max_duty = 0.95;
};

/// sysfs, with the duty cycle's descriptor kept.
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
