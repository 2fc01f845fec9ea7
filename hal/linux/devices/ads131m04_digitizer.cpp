#include "hal/linux/devices/ads131m04_digitizer.hpp"

#include <fmt/format.h>
#include <utility>

#include "hal/linux/system/clock.hpp"

namespace smaservo::hal {

using ads131m04::FrameBytes;
using ads131m04::Register;
using ads131m04::Reply;

Ads131m04Digitizer::Ads131m04Digitizer(std::unique_ptr<SpiPort> port, std::string name,
                                       const Ads131m04Settings& settings)
    : port_(std::move(port)), name_(std::move(name)), settings_(settings) {
  exchange(ads131m04::command_frame(ads131m04::reset_command));
  MonotonicClock::sleep_until(MonotonicClock::now_ns() + 1'000'000);
  const std::optional<std::uint16_t> id = get(Register::id);
  if (!id) {
    throw DeviceError(
        fmt::format("{}: no answer with a right CRC; is it an ADS131M04, in SPI "
                    "mode 1, with its clock?",
                    name_));
  }
  if ((*id & ads131m04::id_mask) != ads131m04::id) {
    throw DeviceError(
        fmt::format("{}: its ID is {:04X}h, not that of an ADS131M04, 24xxh", name_, *id));
  }
  if (!set_up()) {
    throw DeviceError(fmt::format("{}: a register does not read back as it was written", name_));
  }
}

bool Ads131m04Digitizer::read(RawFrame& raw) {
  const std::int64_t time_ns = MonotonicClock::now_ns();
  if (std::exchange(lost_settings_, false) && !set_up()) {
    lost_settings_ = true;
    return false;
  }
  bool fresh = false;
  for (int i = 0; i < 2; ++i) {
    const std::optional<Reply> reply = exchange(ads131m04::command_frame(ads131m04::null_command));
    if (!reply) {
      continue;
    }
    if (ads131m04::was_reset(reply->response)) {
      lost_settings_ = true;
      return false;
    }
    if (ads131m04::all_fresh(reply->response)) {
      fresh = true;
      for (std::size_t c = 0; c < ads131m04::channels; ++c) {
        raw.codes[c] = reply->codes[c];
      }
    }
  }
  if (fresh) {
    raw.time_ns = time_ns;
    raw.sequence = sequence_++;
  }
  return fresh;
}

std::optional<Reply> Ads131m04Digitizer::exchange(const FrameBytes& out) {
  FrameBytes in{};
  if (!port_->transfer(out, in)) {
    return std::nullopt;
  }
  const std::optional<Reply> reply = ads131m04::parse(in);
  damaged_ += reply ? 0U : 1U;
  return reply;
}

bool Ads131m04Digitizer::set_up() {
  return set(Register::clock, ads131m04::clock_register(settings_.osr_exponent)) &&
         set(Register::gain, ads131m04::gain_register(settings_.gain_exponents)) &&
         set(Register::mode, ads131m04::mode);
}

bool Ads131m04Digitizer::set(Register r, std::uint16_t value) {
  exchange(ads131m04::command_frame(ads131m04::write_command(r), value));
  return get(r) == value;
}

/// Reads a register. The answer comes with the frame after that of the command.
std::optional<std::uint16_t> Ads131m04Digitizer::get(Register r) {
  exchange(ads131m04::command_frame(ads131m04::read_command(r)));
  const std::optional<Reply> reply = exchange(ads131m04::command_frame(ads131m04::null_command));
  return reply ? std::optional(reply->response) : std::nullopt;
}

}  // namespace smaservo::hal
