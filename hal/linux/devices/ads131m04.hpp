#pragma once
// The SPI frames of Texas Instruments' ADS131M04 (data sheet SBAS890, sections 8.5 and 8.6),
// without I/O. A frame is six words of 24 bits, most significant bit first: the response, four
// channels and a CRC of these five. 16-bit commands, registers and the CRC are in the upper bits of
// a word.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace smaservo::hal::ads131m04 {

inline constexpr std::size_t channels = 4;
inline constexpr std::size_t word_bytes = 3;
inline constexpr std::size_t frame_bytes = (channels + 2) * word_bytes;
using FrameBytes = std::array<std::uint8_t, frame_bytes>;

enum class Register : std::uint8_t { id = 0, status = 1, mode = 2, clock = 3, gain = 4, cfg = 6 };

inline constexpr std::uint16_t null_command = 0x0000;
inline constexpr std::uint16_t reset_command = 0x0011;
inline constexpr std::uint16_t reset_response = 0xFF24;  ///< FF20h plus the number of channels
inline constexpr std::uint16_t id_mask = 0xFF00;
inline constexpr std::uint16_t id = 0x2400;
/// Mode register: 24-bit words, SPI time-out on, CRC of the CCITT; clears the reset flag.
inline constexpr std::uint16_t mode = 0x0110;
inline constexpr double reference_V = 1.2;  ///< full scale at gain 1

constexpr std::uint16_t read_command(Register r) {
  return static_cast<std::uint16_t>(0xA000U | static_cast<unsigned>(r) << 7U);
}
constexpr std::uint16_t write_command(Register r) {
  return static_cast<std::uint16_t>(0x6000U | static_cast<unsigned>(r) << 7U);
}
constexpr std::uint16_t write_response(Register r) {
  return static_cast<std::uint16_t>(0x4000U | static_cast<unsigned>(r) << 7U);
}

/// Clock register: all four channels on, high resolution, oversampling 128 << `osr_exponent`, which
/// is 0 to 7.
constexpr std::uint16_t clock_register(unsigned osr_exponent) {
  return static_cast<std::uint16_t>(0x0F02U | osr_exponent << 2U);
}
/// Gain register: a channel's gain is 1 << its exponent, which is 0 to 7.
constexpr std::uint16_t gain_register(const std::array<unsigned, channels>& exponents) {
  unsigned bits = 0;
  for (std::size_t i = 0; i < channels; ++i) {
    bits |= exponents[i] << (4 * i);
  }
  return static_cast<std::uint16_t>(bits);
}

/// CRC with polynomial 1021h and initial value FFFFh.
constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8U;
    for (int i = 0; i < 8; ++i) {
      crc = (crc & 0x8000U) != 0 ? (crc << 1U ^ 0x1021U) : crc << 1U;
    }
    crc &= 0xFFFFU;
  }
  return static_cast<std::uint16_t>(crc);
}

/// The frame that sends a command, with the value if it is a write.
constexpr FrameBytes command_frame(std::uint16_t command, std::uint16_t value = 0) {
  FrameBytes bytes{};
  bytes[0] = static_cast<std::uint8_t>(command >> 8U);
  bytes[1] = static_cast<std::uint8_t>(command);
  bytes[3] = static_cast<std::uint8_t>(value >> 8U);
  bytes[4] = static_cast<std::uint8_t>(value);
  return bytes;
}

struct Reply {
  /// The response to the command in the previous frame; for null_command it is the status.
  std::uint16_t response;
  std::array<std::int32_t, channels> codes;
};

/// Reads a received frame; nullopt if the CRC is wrong.
constexpr std::optional<Reply> parse(const FrameBytes& bytes) {
  const std::span<const std::uint8_t> all(bytes);
  const std::size_t end = frame_bytes - word_bytes;
  const auto sum = static_cast<std::uint16_t>(bytes[end] << 8U | bytes[end + 1]);
  if (crc16(all.first(end)) != sum) {
    return std::nullopt;
  }
  Reply reply{static_cast<std::uint16_t>(bytes[0] << 8U | bytes[1]), {}};
  for (std::size_t i = 0; i < channels; ++i) {
    const std::size_t at = (i + 1) * word_bytes;
    const auto word = static_cast<std::uint32_t>(bytes[at]) << 24U |
                      static_cast<std::uint32_t>(bytes[at + 1]) << 16U |
                      static_cast<std::uint32_t>(bytes[at + 2]) << 8U;
    reply.codes[i] = static_cast<std::int32_t>(word) >> 8;
  }
  return reply;
}

/// Whether a status says that all channels have a new sample.
constexpr bool all_fresh(std::uint16_t status) {
  return (status & 0x000FU) == 0x000FU;
}
/// Whether a status says that the converter was reset and has lost its settings.
constexpr bool was_reset(std::uint16_t status) {
  return (status & 0x0400U) != 0;
}

}  // namespace smaservo::hal::ads131m04
