#pragma once

#include <memory>

#include "hal/linux/devices/ads131m04.hpp"
#include "hal/linux/devices/digitizer.hpp"
#include "hal/linux/devices/spi.hpp"

namespace smaservo::hal {

struct Ads131m04Settings {
  /// Oversampling 128 << 3 = 1024: 4000 samples a second with a clock of 8.192 MHz.
  unsigned osr_exponent = 3;
  std::array<unsigned, ads131m04::channels> gain_exponents{};
};

/// An ADS131M04 at an SPI port. The converter keeps two samples: both are read and the newer one is
/// used. After a reset, for example by a dip of its supply, it is set up again before its samples
/// are used.
class Ads131m04Digitizer : public Digitizer {
 public:
  /// Resets the converter and sets it up; throws DeviceError if its answers are wrong.
  Ads131m04Digitizer(std::unique_ptr<SpiPort> port, std::string name,
                     const Ads131m04Settings& settings);
  bool read(RawFrame& raw) override;

  std::uint64_t damaged() const { return damaged_; }  ///< frames with a wrong CRC

 private:
  std::optional<ads131m04::Reply> exchange(const ads131m04::FrameBytes& out);
  bool set_up();
  bool set(ads131m04::Register r, std::uint16_t value);
  std::optional<std::uint16_t> get(ads131m04::Register r);

  std::unique_ptr<SpiPort> port_;
  std::string name_;
  Ads131m04Settings settings_;
  bool lost_settings_ = false;
  std::uint32_t sequence_ = 0;
  std::uint64_t damaged_ = 0;
};

}  // namespace smaservo::hal
