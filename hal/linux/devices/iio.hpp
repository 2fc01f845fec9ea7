#pragma once
// Industrial I/O of the kernel: a converter's buffer, a converter's outputs.

#include <string>
#include <vector>

#include "hal/linux/devices/digitizer.hpp"
#include "hal/linux/devices/iio_scan.hpp"
#include "hal/linux/system/files.hpp"

namespace smaservo::hal {

struct IioSettings {
  std::string device;                 ///< as its attribute `name` says
  std::vector<std::string> channels;  ///< scan elements, "in_voltage0"
  std::string trigger;                ///< name; empty: the device's own
  double hrtimer_Hz = 0;              ///< above 0: makes the trigger, a timer, where it is missing
  unsigned buffer_length = 16;
  std::int64_t longest_wait_ns = 500'000;
};

/// Scans of a triggered buffer; the newest counts. Codes are in the order of the settings'
/// channels.
class IioDigitizer : public Digitizer {
 public:
  /// Sets the buffer up and starts it. Throws DeviceError.
  IioDigitizer(const LinuxRoots& roots, const IioSettings& settings);
  ~IioDigitizer() override;
  IioDigitizer(const IioDigitizer&) = delete;
  IioDigitizer& operator=(const IioDigitizer&) = delete;

  bool read(RawFrame& raw) override;

  /// SI by code: code + offset, times scale, as the driver says; 1 and 0 where it says nothing.
  struct Meaning {
    double scale, offset;
  };
  const std::vector<Meaning>& meanings() const { return meanings_; }

 private:
  void enable(const IioSettings& settings);
  bool wait() const;

  std::string folder_;
  ScanLayout layout_;
  std::size_t channels_;
  bool has_time_ = false;
  std::vector<Meaning> meanings_;
  std::vector<std::byte> scans_;
  std::int64_t longest_wait_ns_;
  Descriptor file_;
  std::uint32_t sequence_ = 0;
};

}  // namespace smaservo::hal
