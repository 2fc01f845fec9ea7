#include "hal/linux/devices/iio_scan.hpp"

#include <algorithm>
#include <charconv>
#include <numeric>

namespace smaservo::hal {
namespace {

std::optional<unsigned> take_number(std::string_view& text) {
  unsigned value = 0;
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) {
    return std::nullopt;
  }
  text.remove_prefix(static_cast<std::size_t>(at - text.data()));
  return value;
}

bool take(std::string_view& text, std::string_view what) {
  const bool there = text.starts_with(what);
  text.remove_prefix(there ? what.size() : 0);
  return there;
}

}  // namespace

std::optional<ScanType> parse_scan_type(std::string_view text) {
  ScanType type{};
  type.big_endian = take(text, "be:");
  if (!type.big_endian && !take(text, "le:")) {
    return std::nullopt;
  }
  type.is_signed = take(text, "s");
  if (!type.is_signed && !take(text, "u")) {
    return std::nullopt;
  }
  const auto bits = take_number(text);
  const bool slash = take(text, "/");
  const auto storage = take_number(text);
  const bool arrow = take(text, ">>");
  const auto shift = take_number(text);
  if (!bits || !slash || !storage || !arrow || !shift || !text.empty()) {
    return std::nullopt;
  }
  type.bits = *bits;
  type.storage = *storage;
  type.shift = *shift;
  const bool size = *storage == 8 || *storage == 16 || *storage == 32 || *storage == 64;
  return size && *bits >= 1 && *bits + *shift <= *storage ? std::optional(type) : std::nullopt;
}

ScanLayout lay_out(std::span<const ScanElement> elements) {
  std::vector<std::size_t> order(elements.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return elements[i].index; });
  ScanLayout layout{std::vector<PlacedElement>(elements.size()), 0};
  std::size_t widest = 1;
  const auto aligned = [](std::size_t at, std::size_t to) { return (at + to - 1) / to * to; };
  for (const std::size_t i : order) {
    const std::size_t bytes = elements[i].type.storage / 8;
    layout.size = aligned(layout.size, bytes);
    layout.elements[i] = {elements[i].type, layout.size};
    layout.size += bytes;
    widest = std::max(widest, bytes);
  }
  layout.size = aligned(layout.size, widest);
  return layout;
}

std::int64_t sample_of(const PlacedElement& element, std::span<const std::byte> scan) {
  const ScanType& type = element.type;
  const std::size_t bytes = type.storage / 8;
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    const std::size_t at = type.big_endian ? bytes - 1 - i : i;
    word |= static_cast<std::uint64_t>(scan[element.offset + at]) << (8 * i);
  }
  word = word >> type.shift << (64 - type.bits);
  return type.is_signed ? static_cast<std::int64_t>(word) >> (64 - type.bits)
                        : static_cast<std::int64_t>(word >> (64 - type.bits));
}

}  // namespace smaservo::hal
