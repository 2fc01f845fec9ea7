#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "hal/linux/system/files.hpp"

namespace smaservo::hal {

class SpiPort {
 public:
  SpiPort() = default;
  virtual ~SpiPort() = default;
  SpiPort(const SpiPort&) = delete;
  SpiPort& operator=(const SpiPort&) = delete;

  /// Sends `out` and receives `in`, of equal sizes, at the same time, with the chip selected. False
  /// if the transfer failed.
  virtual bool transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) = 0;
};

struct SpiSettings {
  std::string device = "spidev0.0";
  unsigned mode = 1;
  std::uint32_t clock_Hz = 8'000'000;
};

/// An SpiPort through spidev. Cost of a transfer: one system call, which takes the time on the bus
/// plus about 10 us.
class SpiDevice : public SpiPort {
 public:
  /// Throws DeviceError.
  SpiDevice(const LinuxRoots& roots, const SpiSettings& settings);
  bool transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) override;
  int descriptor() const { return file_.number(); }

 private:
  Descriptor file_;
  std::uint32_t clock_Hz_;
};

}  // namespace smaservo::hal
