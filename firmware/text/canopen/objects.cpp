#include "firmware/text/canopen/objects.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <optional>

#include "firmware/canopen/node/communication.hpp"
#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/servo/drive_objects.hpp"
#include "firmware/signals.hpp"
#include "firmware/text/canopen/object_list.hpp"
#include "firmware/text/settings_text.hpp"
#include "firmware/text/signal_names.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/similar.hpp"

namespace smaservo::text {
namespace {

namespace index = canopen::index;

using canopen::Type;

constexpr std::uint16_t faults_object = 0x2202;

void add(std::vector<KnownObject>& all, std::span<const canopen::DescribedObject> rows,
         std::span<const canopen::IndexName> names) {
  for (const canopen::DescribedObject& row : rows) {
    const Key key = row.object.key;
    std::string name(row.name);
    const auto group = std::ranges::find(names, key.index, &canopen::IndexName::index);
    // The names in the manufacturer's area already contain their group.
    const bool standard = key.index < 0x2000 || 0x6000 <= key.index;
    if (standard && group != names.end()) {
      name = fmt::format("{}, {}", group->name, row.name);
    }
    all.push_back({key, row.object.type, name, std::string(row.meaning),
                   (row.object.access & canopen::writable) != 0, nullptr});
  }
}

std::vector<KnownObject> all_objects() {
  std::vector<KnownObject> all;
  add(all, canopen::communication_rows, canopen::communication_names);
  for (const Parameter<double>& row : parameters<double>) {
    all.push_back({row.key, type_of(row.type), std::string(row.path.text()),
                   std::string(row.meaning), true, &row, row.kind.front(),
                   row.type == ValueType::real ? row.kind : Kind()});
  }
  for (std::size_t i = 0; i < signal_count; ++i) {
    all.push_back({{live_values, sub_of(i)},
                   Type::real,
                   fmt::format("{}{}", live_prefix, signal_rows<double>[i].name),
                   std::string(signal_rows<double>[i].meaning),
                   false,
                   nullptr,
                   signal_kind(i).front(),
                   signal_kind(i)});
  }
  add(all, canopen::drive_object_rows, canopen::drive_object_names);
  std::ranges::sort(all, {}, &KnownObject::key);
  return all;
}

/// Reads a number to this base; false unless it is the whole text.
template <class Number>
bool whole(std::string_view text, Number& number, int base) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  return error == std::errc{} && end == text.data() + text.size();
}

/// "2100:1", "2100h:1", "0x2100:1", "2100"
bool read_key(std::string_view text, Key& key) {
  const std::size_t colon = text.find(':');
  std::string_view index = text.substr(0, colon);
  if (index.starts_with("0x")) {
    index.remove_prefix(2);
  }
  if (index.ends_with('h')) {
    index.remove_suffix(1);
  }
  key.sub = 0;
  return index.size() == 4 && whole(index, key.index, 16) &&
         (colon == std::string_view::npos || whole(text.substr(colon + 1), key.sub, 10));
}

/// The object's name without its unit: "limits.current" of "limits.current_A"
std::string_view base_name(const KnownObject& object) {
  std::string_view name = object.name;
  const std::string_view suffix = object.unit.suffix;
  name.remove_suffix(suffix.empty() ? 0 : suffix.size() + 1);
  return name;
}

/// Whether `name` is the name of an object, or that of a live value without "live.".
bool is_called(std::string_view object, std::string_view name) {
  return object == name ||
         (object.starts_with(live_prefix) && object.substr(live_prefix.size()) == name);
}

std::optional<KnownObject> named(std::string_view name) {
  for (const KnownObject& object : known_objects()) {
    if (is_called(object.name, name)) {
      return object;
    }
    for (const Unit& other : object.kind) {
      if (is_called(files::key_with(base_name(object), other.suffix), name)) {
        return in_unit(object, other);
      }
    }
  }
  return std::nullopt;
}

/// A word without a dot may have meant a live value without "live.".
std::vector<std::string> close_names(std::string_view name) {
  const bool bare = name.find('.') == std::string_view::npos;
  std::vector<std::string> names;
  for (const KnownObject& object : known_objects()) {
    names.push_back(bare && object.name.starts_with(live_prefix)
                        ? object.name.substr(live_prefix.size())
                        : object.name);
  }
  return files::similar(name, names);
}

/// What a name of former versions is called now; the same name where it was not renamed.
std::string renamed(const std::string& name) {
  const bool live = name.starts_with(live_prefix);
  const std::string signal = live ? name.substr(live_prefix.size()) : name;
  const std::string_view now = renamed_signal(signal);
  return !now.empty() ? fmt::format("{}{}", live ? live_prefix : "", now)
                      : files::renamed_key(name);
}

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02X}", fmt::join(bytes, " "));
}

std::int64_t sign_extended(std::span<const std::uint8_t> bytes) {
  const auto shift = 64 - 8 * static_cast<unsigned>(bytes.size());
  return static_cast<std::int64_t>(canopen::take_number(bytes) << shift) >> shift;
}

/// The shortest text that gives this float when it is read in this unit.
std::string real_text(float value, const Unit& unit) {
  if (!std::isfinite(value) || (unit.factor == 1 && unit.offset == 0)) {
    return fmt::format("{}", value);
  }
  constexpr int most_digits = 15;
  const double exact = unit.from_si(static_cast<double>(value));
  // No rounding of the tiny remainder of an offset is 0.
  if (static_cast<float>(unit.to_si(0)) == value) {
    return "0";
  }
  double rounded = exact;
  for (int digits = 1; digits <= most_digits; ++digits) {
    rounded = std::stod(fmt::format("{:.{}g}", exact, digits));
    if (static_cast<float>(unit.to_si(rounded)) == value) {
      break;
    }
  }
  return fmt::format("{}", rounded);
}

[[noreturn]] void bad_value(const KnownObject& object, const std::string& text,
                            std::string_view allowed) {
  throw files::UserError(fmt::format("{} = {}: must be {}", title(object), text, allowed));
}

std::uint64_t integer(const KnownObject& object, std::string text) {
  const auto size = canopen::size_of(object.type);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
    text.erase(0, 1);
  }
  if (canopen::is_signed(object.type)) {
    const std::int64_t limit = std::int64_t{1} << (8 * size - 1);
    std::int64_t number = 0;
    if (!whole(text, number, 10) || (size < 8 && (number < -limit || number >= limit))) {
      bad_value(object, text, fmt::format("a whole number from {} to {}", -limit, limit - 1));
    }
    return static_cast<std::uint64_t>(number);
  }
  const std::uint64_t limit =
      size < 8 ? (std::uint64_t{1} << (8 * size)) - 1 : std::numeric_limits<std::uint64_t>::max();
  std::uint64_t number = 0;
  const bool hex = text.starts_with("0x");
  if (!whole(std::string_view(text).substr(hex ? 2 : 0), number, hex ? 16 : 10) || number > limit) {
    bad_value(object, text, fmt::format("a whole number from 0 to {}", limit));
  }
  return number;
}

std::uint64_t boolean_or_choice(const KnownObject& object, const std::string& text) {
  if (object.type == Type::boolean) {
    if (text == "true" || text == "1") {
      return 1;
    }
    if (text == "false" || text == "0") {
      return 0;
    }
    bad_value(object, text, "true or false");
  }
  const auto& choices = object.parameter->choices;
  const auto found = std::ranges::find(choices, text);
  if (found == choices.end()) {
    bad_value(object, text, fmt::format("{}", fmt::join(choices, ", ")));
  }
  return static_cast<std::uint64_t>(found - choices.begin());
}

bool is_choice(const KnownObject& object) {
  return object.parameter != nullptr && object.parameter->type == ValueType::choice;
}

float real(const KnownObject& object, const std::string& text) {
  const std::optional<Quantity> quantity = quantity_of(text);
  const std::optional<Unit> unit =
      quantity ? quantity->unit_in(object.kind, object.unit) : std::nullopt;
  if (!unit) {
    const std::string units = suffixes_text(object.kind);
    bad_value(object, text,
              units.empty() ? "a number"
                            : fmt::format("a number, or one with a unit behind it: {}", units));
  }
  return static_cast<float>(unit->to_si(quantity->number));
}

std::vector<std::uint8_t> octets(const KnownObject& object, std::string_view text) {
  std::vector<std::uint8_t> bytes;
  if (text.starts_with("0x")) {
    text.remove_prefix(2);
  }
  for (std::size_t i = 0; i < text.size(); i += 2) {
    std::uint8_t byte = 0;
    if (i + 2 > text.size() || !whole(text.substr(i, 2), byte, 16)) {
      bad_value(object, std::string(text),
                "an even number of hexadecimal digits, lowest byte first");
    }
    bytes.push_back(byte);
  }
  return bytes;
}

}  // namespace

const std::vector<KnownObject>& known_objects() {
  static const std::vector<KnownObject> all = all_objects();
  return all;
}

KnownObject find_object(const std::string& text) {
  Key key{};
  if (read_key(text, key)) {
    const auto at = std::ranges::lower_bound(known_objects(), key, {}, &KnownObject::key);
    if (at != known_objects().end() && at->key == key) {
      return *at;
    }
    return {key, Type::octets, "", "", true, nullptr};
  }
  if (const std::optional<KnownObject> object = named(text)) {
    return *object;
  }
  if (const std::string now = renamed(text); named(now)) {
    throw files::UserError(fmt::format("{}: is now called {}", text, now));
  }
  const std::vector<std::string> close = close_names(text);
  throw files::UserError(
      close.empty()
          ? fmt::format("{}: no such object; give a name of firmware/reference/OBJECTS.md or "
                        "PARAMETERS.md, or INDEX:SUB, such as 2100:1",
                        text)
          : fmt::format("{}: no such object; did you mean {}?", text, fmt::join(close, ", ")));
}

KnownObject find_quantity(const std::string& text, bool& unitless) {
  unitless = false;
  Key key{};
  if (!read_key(text, key) && !named(text)) {
    for (const KnownObject& object : known_objects()) {
      if (!object.unit.suffix.empty() && is_called(base_name(object), text)) {
        unitless = true;
        return object;
      }
    }
  }
  return find_object(text);
}

KnownObject in_unit(const KnownObject& object, const Unit& unit) {
  KnownObject other = object;
  other.name = files::key_with(base_name(object), unit.suffix);
  other.unit = unit;
  return other;
}

std::string title(const KnownObject& object) {
  const std::string key = fmt::format("{:04X}h:{}", object.key.index, object.key.sub);
  return object.name.empty() ? key : fmt::format("{} ({})", object.name, key);
}

std::string value_text(const KnownObject& object, std::span<const std::uint8_t> bytes) {
  const std::size_t size = canopen::size_of(object.type);
  if (object.type == Type::text) {
    return files::printable(std::string(bytes.begin(), bytes.end()));
  }
  if (size == 0 || bytes.size() != size) {
    return hexadecimal(bytes);
  }
  const std::uint64_t number = canopen::take_number(bytes);
  if (object.type == Type::real) {
    return real_text(canopen::as_real(static_cast<std::uint32_t>(number)), object.unit);
  }
  if (is_choice(object) && number < object.parameter->choices.size()) {
    return std::string(object.parameter->choices[static_cast<std::size_t>(number)]);
  }
  if (object.type == Type::boolean) {
    return number != 0 ? "true" : "false";
  }
  if (canopen::is_signed(object.type)) {
    return fmt::format("{}", sign_extended(bytes));
  }
  // Codes and sets of bits are easier to read in hexadecimal.
  const bool bits = object.key.index == index::controlword ||
                    object.key.index == index::statusword ||
                    object.key.index == index::error_code || object.key.index == faults_object ||
                    (object.key.index < 0x2000 && size == 4);
  return bits ? fmt::format("0x{:0{}X}", number, 2 * size) : fmt::format("{}", number);
}

double value_number(const KnownObject& object, std::span<const std::uint8_t> bytes) {
  const std::size_t size = canopen::size_of(object.type);
  if (size == 0 || bytes.size() != size) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (object.type == Type::real) {
    const auto bits = static_cast<std::uint32_t>(canopen::take_number(bytes));
    return static_cast<double>(canopen::as_real(bits));
  }
  return canopen::is_signed(object.type) ? static_cast<double>(sign_extended(bytes))
                                         : static_cast<double>(canopen::take_number(bytes));
}

std::vector<std::uint8_t> value_bytes(const KnownObject& object, const std::string& text) {
  if (object.type == Type::text) {
    return {text.begin(), text.end()};
  }
  const std::size_t size = canopen::size_of(object.type);
  if (size == 0) {
    return octets(object, text);
  }
  std::vector<std::uint8_t> bytes(size);
  const std::uint64_t number = object.type == Type::real ? canopen::as_bits(real(object, text))
                               : object.type == Type::boolean || is_choice(object)
                                   ? boolean_or_choice(object, text)
                                   : integer(object, text);
  canopen::put_number(bytes, number);
  return bytes;
}

std::string allowed_text(const KnownObject& object) {
  if (object.parameter == nullptr) {
    return "";
  }
  if (object.type != Type::real || (object.unit.factor == 1 && object.unit.offset == 0)) {
    return fmt::format("{}{}{}", range_text(*object.parameter),
                       object.unit.suffix.empty() ? "" : " ", object.unit.suffix);
  }
  return fmt::format("{} to {} {}", real_text(object.parameter->min.real(), object.unit),
                     real_text(object.parameter->max.real(), object.unit), object.unit.suffix);
}

}  // namespace smaservo::text
