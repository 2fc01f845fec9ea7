#include "host-sim/page/servos/traffic/expedited.hpp"

#include <span>

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/object.hpp"

namespace smaservo::page {

namespace index = canopen::index;

hal::CanFrame sdo_request(unsigned node, Key key, std::optional<std::uint16_t> value) {
  hal::CanFrame frame{.id = 0x600 + node, .length = 8, .data = {}};
  frame.data[0] = value ? 0x2B : 0x40;
  canopen::put_number(std::span(frame.data).subspan(4, 2), value.value_or(0));
  canopen::put_number(std::span(frame.data).subspan(1, 2), key.index);
  frame.data[3] = key.sub;
  return frame;
}

Key sdo_key(const hal::CanFrame& frame) {
  return {static_cast<std::uint16_t>(canopen::take_number(std::span(frame.data).subspan(1, 2))),
          frame.data[3]};
}

std::optional<std::uint32_t> sdo_value(const hal::CanFrame& answer) {
  if ((answer.data[0] & 0xE2U) != 0x42) {
    return std::nullopt;
  }
  const std::size_t unused = (answer.data[0] & 1U) != 0 ? (answer.data[0] >> 2U) & 3U : 0;
  return static_cast<std::uint32_t>(
      canopen::take_number(std::span(answer.data).subspan(4, 4 - unused)));
}

void note_command(const hal::CanFrame& request, std::int64_t now_us, Commanded& commanded) {
  if ((request.data[0] & 0xE2U) != 0x22) {
    return;
  }
  const Key key = sdo_key(request);
  if (key == Key{index::controlword, 0}) {
    commanded.word =
        static_cast<std::uint16_t>(canopen::take_number(std::span(request.data).subspan(4, 2)));
    commanded.time_us = now_us;
  } else if (key == Key{index::mode, 0}) {
    commanded.mode = static_cast<std::int8_t>(request.data[4]);
  }
}

bool needs_renewal(const Servo& servo, std::int64_t now_us) {
  constexpr std::int64_t period_us = 250'000;
  const Commanded& last = servo.commanded;
  return servo.online && !servo.duplicate && servo.enabled_us != 0 && last.word &&
         now_us - last.time_us >= period_us;
}

hal::CanFrame command_pdo(const Servo& servo) {
  const Commanded& last = servo.commanded;
  hal::CanFrame frame{.id = 0x200 + servo.node, .length = 3, .data = {}};
  canopen::put_number(std::span(frame.data).first(2), last.word.value_or(0));
  frame.data[2] =
      static_cast<std::uint8_t>(last.mode.value_or(static_cast<std::int8_t>(servo.mode())));
  return frame;
}

}  // namespace smaservo::page
