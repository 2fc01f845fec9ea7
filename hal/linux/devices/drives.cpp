#include "hal/linux/devices/drives.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/spi/spidev.h>
#include <utility>

namespace smaservo::hal {

std::int64_t dac_code(const DacScale& scale, const DriveCommand& command) {
  const double value = scale.voltage ? command.voltage_V : command.current_A;
  if (!(value > 0)) {
    return std::llround(scale.zero_code);
  }
  const double code = scale.zero_code + value * scale.codes_per_unit;
  return std::llround(std::clamp(code, 0.0, scale.max_code));
}

IioDac::IioDac(const LinuxRoots& roots, const IioDacSettings& settings)
    : scale_(settings.scale),
      file_(open_file(
          fmt::format("{}/{}_raw",
                      find_by_name(roots.sys + "/bus/iio/devices", "iio:device", settings.device),
                      settings.channel),
          O_WRONLY)),
      off_(std::to_string(dac_code(scale_, {}))) {
  take_output(file_.number(), settings.device + " " + settings.channel, roots);
  if (!off()) {
    throw DeviceError(fmt::format("{} {}: the code for no output cannot be written",
                                  settings.device, settings.channel));
  }
}

bool IioDac::put(const DriveCommand& command) {
  return put_number(file_.number(), dac_code(scale_, command));
}

OffAction IioDac::off_action() {
  return {file_.number(), 0, off_.data(), off_.size()};
}

std::array<std::uint8_t, 3> dac_frame(const SpiDacSettings& settings, std::int64_t code) {
  const std::uint32_t word = settings.command | static_cast<std::uint32_t>(code) << settings.shift;
  std::array<std::uint8_t, 3> bytes{};
  for (unsigned i = 0; i < settings.frame_bytes; ++i) {
    bytes.at(i) = static_cast<std::uint8_t>(word >> (8 * (settings.frame_bytes - 1 - i)));
  }
  return bytes;
}

struct SpiDac::OffTransfer {
  std::array<std::uint8_t, 3> bytes;
  spi_ioc_transfer message;
};

SpiDac::SpiDac(const LinuxRoots& roots, const SpiDacSettings& settings,
               std::unique_ptr<SpiPort> port)
    : settings_(settings), port_(std::move(port)) {
  if (!port_) {
    auto device = std::make_unique<SpiDevice>(roots, settings.spi);
    descriptor_ = device->descriptor();
    take_output(descriptor_, roots.dev + "/" + settings.spi.device, roots);
    port_ = std::move(device);
  }
  off_ = std::make_unique<OffTransfer>();
  off_->bytes = dac_frame(settings_, dac_code(settings_.scale, {}));
  off_->message.tx_buf = std::bit_cast<std::uintptr_t>(off_->bytes.data());
  off_->message.len = settings_.frame_bytes;
  off_->message.speed_hz = settings_.spi.clock_Hz;
  off_->message.bits_per_word = 8;
  if (!off()) {
    throw DeviceError(fmt::format("{}: the transfer fails", settings.spi.device));
  }
}
SpiDac::~SpiDac() = default;

bool SpiDac::put(const DriveCommand& command) {
  const auto bytes = dac_frame(settings_, dac_code(settings_.scale, command));
  std::array<std::uint8_t, 3> answer{};
  const std::size_t size = settings_.frame_bytes;
  return port_->transfer(std::span(bytes).first(size), std::span(answer).first(size));
}

OffAction SpiDac::off_action() {
  return {descriptor_, SPI_IOC_MESSAGE(1), &off_->message, 0};
}

PwmDrive::PwmDrive(const LinuxRoots& roots, const PwmSettings& settings) : settings_(settings) {
  const std::string chip = roots.sys + "/class/pwm/" + settings.chip;
  const std::string folder = fmt::format("{}/pwm{}", chip, settings.channel);
  if (!exists(folder)) {
    write_text(chip + "/export", std::to_string(settings.channel));
  }
  wait_until_writable(folder + "/duty_cycle");
  duty_ = open_file(folder + "/duty_cycle", O_WRONLY);
  take_output(duty_.number(), folder + "/duty_cycle", roots);
  // The kernel refuses a period below the duty cycle, and another program may have left a large
  // duty cycle.
  if (!off()) {
    throw DeviceError(folder + "/duty_cycle: 0 cannot be written");
  }
  write_text(folder + "/period", std::to_string(settings.period_ns));
  write_text(folder + "/enable", "1");
}

bool PwmDrive::put(const DriveCommand& command) {
  const double duty = command.voltage_V > 0 ? command.voltage_V / settings_.supply_V : 0;
  const double share = std::min(duty, settings_.max_duty);
  return put_number(duty_.number(), std::llround(share * static_cast<double>(settings_.period_ns)));
}

OffAction PwmDrive::off_action() {
  return {duty_.number(), 0, &zero_, 1};
}

}  // namespace smaservo::hal
