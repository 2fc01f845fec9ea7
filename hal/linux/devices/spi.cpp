#include "hal/linux/devices/spi.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/spi/spidev.h>
#include <sys/ioctl.h>

namespace smaservo::hal {

SpiDevice::SpiDevice(const LinuxRoots& roots, const SpiSettings& settings)
    : file_(open_file(roots.dev + "/" + settings.device, O_RDWR)), clock_Hz_(settings.clock_Hz) {
  auto mode = static_cast<std::uint8_t>(settings.mode);
  std::uint8_t bits = 8;
  if (ioctl(file_.number(), SPI_IOC_WR_MODE, &mode) != 0 ||
      ioctl(file_.number(), SPI_IOC_WR_BITS_PER_WORD, &bits) != 0 ||
      ioctl(file_.number(), SPI_IOC_WR_MAX_SPEED_HZ, &clock_Hz_) != 0) {
    throw DeviceError(fmt::format("{}/{}: mode {} at {} Hz: {}", roots.dev, settings.device,
                                  settings.mode, clock_Hz_, std::strerror(errno)));
  }
}

bool SpiDevice::transfer(std::span<const std::uint8_t> out, std::span<std::uint8_t> in) {
  spi_ioc_transfer message{};
  message.tx_buf = std::bit_cast<std::uintptr_t>(out.data());
  message.rx_buf = std::bit_cast<std::uintptr_t>(in.data());
  message.len = static_cast<std::uint32_t>(std::min(out.size(), in.size()));
  message.speed_hz = clock_Hz_;
  message.bits_per_word = 8;
  return ioctl(file_.number(), SPI_IOC_MESSAGE(1), &message) == static_cast<int>(message.len);
}

}  // namespace smaservo::hal
