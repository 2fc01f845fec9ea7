#pragma once
// A converter that is read through a buffer of the kernel's Industrial I/O (IIO).

#include <string>
#include <vector>

#include "hal/linux/devices/digitizer.hpp"
#include "hal/linux/devices/iio_scan.hpp"
#include "hal/linux/system/files.hpp"

namespace smaservo::hal {

struct IioSettings {
  std::string device;                 ///< value of its attribute `name`
  std::vector<std::string> channels;  ///< names of scan elements, such as "in_voltage0"
  std::string trigger;                ///< name of the trigger; empty: the device's own
  /// Above 0: frequency of a timer trigger, which is created if it does not exist.
  double hrtimer_Hz = 0;
  unsigned buffer_length = 16;
  std::int64_t longest_wait_ns = 500'000;
};

/// Reads the newest scan of a triggered buffer. Codes are in the order of IioSettings::channels.
class IioDigitizer : public Digitizer {
 public:
  /// Sets the buffer up and starts it. Throws DeviceError.
  IioDigitizer(const LinuxRoots& roots, const IioSettings& settings);
  ~IioDigitizer() override;
  IioDigitizer(const IioDigitizer&) = delete;
  IioDigitizer& operator=(const IioDigitizer&) = delete;

  bool read(RawFrame& raw) override;

  /// The driver's calibration: SI is (code + offset) * scale. If the driver has none, scale is 1
  /// and offset 0.
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
