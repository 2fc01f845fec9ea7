#include "tests/can/eds_node/eds_file.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <fmt/format.h>
#include <map>
#include <optional>

#include "model/files/error.hpp"

namespace smaservo {
namespace {

using canopen::Type;

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string_view::npos
             ? std::string_view{}
             : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// A piece of a file that may be anything, for a terminal.
std::string shown_text(std::string_view text) {
  constexpr std::size_t max = 60;
  std::string shown(text.substr(0, max));
  std::ranges::replace_if(shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > max ? shown + "..." : shown;
}

/// Keys and section names do not mind their case.
class Section {
 public:
  Section(std::string file, std::string name) : file_(std::move(file)), name_(std::move(name)) {}

  void add(const std::string& key, const std::string& value) { values_[lower(key)] = value; }
  /// Nothing for a key that is missing or empty.
  std::optional<std::string> find(std::string_view key) const {
    const auto at = values_.find(lower(key));
    return at == values_.end() || at->second.empty() ? std::nullopt : std::optional(at->second);
  }
  [[noreturn]] void refuse(std::string_view key, std::string_view value,
                           std::string_view wanted) const {
    throw files::UserError(fmt::format("{}: [{}] {}={}: must be {}", file_, shown_text(name_), key,
                                       shown_text(value), wanted));
  }
  std::int64_t number(std::string_view key, std::uint8_t node_id) const;
  std::int64_t number(std::string_view key, std::uint8_t node_id, std::int64_t missing) const {
    return find(key) ? number(key, node_id) : missing;
  }

 private:
  std::string file_, name_;
  std::map<std::string, std::string> values_;
};

/// Decimal, 0x hexadecimal or 0 octal, as C has them.
std::optional<std::int64_t> whole_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  text.remove_prefix(negative ? 1 : 0);
  int base = 10;
  if (text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.size() > 1 && text[0] == '0') {
    base = 8;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) {
    return {};
  }
  return static_cast<std::int64_t>(negative ? 0 - value : value);
}

std::int64_t Section::number(std::string_view key, std::uint8_t node_id) const {
  const std::string value = find(key).value_or("");
  std::int64_t sum = 0;
  std::string_view rest = value;
  bool any = false;
  while (!rest.empty() || !any) {
    const std::size_t plus = rest.find('+');
    const std::string_view part = trimmed(rest.substr(0, plus));
    const std::optional<std::int64_t> number =
        lower(part) == "$nodeid" ? std::optional<std::int64_t>(node_id) : whole_number(part);
    if (!number) {
      refuse(key, value, "a whole number");
    }
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) +
                                    static_cast<std::uint64_t>(*number));
    any = true;
    rest = plus == std::string_view::npos ? std::string_view{} : rest.substr(plus + 1);
  }
  return sum;
}

using Sections = std::map<std::string, Section>;

Sections read_sections(std::string_view text, const std::string& file) {
  Sections sections;
  Section* open = nullptr;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line[0] == ';' || line[0] == '#') {
      continue;
    }
    if (line[0] == '[') {
      if (line.back() != ']') {
        throw files::UserError(
            fmt::format("{}:{}: {}: a section ends with ]", file, number, shown_text(line)));
      }
      const std::string name(line.substr(1, line.size() - 2));
      const auto [at, fresh] = sections.try_emplace(lower(name), file, name);
      if (!fresh) {
        throw files::UserError(
            fmt::format("{}:{}: [{}]: stands there twice", file, number, shown_text(name)));
      }
      open = &at->second;
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos || open == nullptr) {
      throw files::UserError(fmt::format("{}:{}: {}: must be key=value within a section", file,
                                         number, shown_text(line)));
    }
    open->add(std::string(trimmed(line.substr(0, equals))),
              std::string(trimmed(line.substr(equals + 1))));
  }
  return sections;
}

Type type_of(const Section& section) {
  const std::int64_t number = section.number("DataType", 0);
  constexpr std::array known{Type::boolean, Type::i8,  Type::i16,  Type::i32,  Type::u8,
                             Type::u16,     Type::u32, Type::real, Type::text, Type::octets,
                             Type::domain,  Type::f64, Type::i64,  Type::u64};
  for (const Type type : known) {
    if (static_cast<std::int64_t>(type) == number) {
      return type;
    }
  }
  section.refuse("DataType", section.find("DataType").value_or(""),
                 "a type of 1 to 8, 9, 0xA, 0xF, 0x11, 0x15 or 0x1B");
}

std::uint16_t access_of(const Section& section) {
  using namespace canopen;
  const std::string access = lower(section.find("AccessType").value_or("rw"));
  const bool mapped = section.number("PDOMapping", 0, 0) != 0;
  const unsigned in = mapped ? in_rpdo : 0U;
  const unsigned out = mapped ? in_tpdo : 0U;
  unsigned rights = 0;
  if (access == "ro") {
    rights = readable | out;
  } else if (access == "const") {
    rights = readable | constant | out;
  } else if (access == "wo") {
    rights = writable | in;
  } else if (access == "rw") {
    rights = readable | writable | in | out;
  } else if (access == "rww") {
    rights = readable | writable | in;
  } else if (access == "rwr") {
    rights = readable | writable | out;
  } else {
    section.refuse("AccessType", access, "ro, wo, rw, rwr, rww or const");
  }
  return static_cast<std::uint16_t>(rights);
}

std::vector<std::uint8_t> real_bytes(const Section& section, std::string_view text, Type type) {
  std::vector<std::uint8_t> bytes(canopen::size_of(type));
  // Some write the bits, some the number.
  if (text.starts_with("0x") || text.starts_with("0X")) {
    canopen::put_number(bytes, static_cast<std::uint64_t>(section.number("DefaultValue", 0)));
    return bytes;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    section.refuse("DefaultValue", text, "a number");
  }
  canopen::put_number(bytes, type == Type::real ? canopen::as_bits(static_cast<float>(value))
                                                : std::bit_cast<std::uint64_t>(value));
  return bytes;
}

std::vector<std::uint8_t> default_of(const Section& section, Type type, std::uint8_t node_id) {
  const std::string text = section.find("DefaultValue").value_or("");
  if (type == Type::text || type == Type::octets || type == Type::domain) {
    return {text.begin(), text.end()};
  }
  if (type == Type::real || type == Type::f64) {
    return real_bytes(section, text.empty() ? "0" : text, type);
  }
  std::vector<std::uint8_t> bytes(canopen::size_of(type));
  canopen::put_number(bytes,
                      static_cast<std::uint64_t>(section.number("DefaultValue", node_id, 0)));
  return bytes;
}

EdsObject object_of(const Section& section, Key key, std::uint8_t node_id) {
  EdsObject object{};
  object.key = key;
  object.name = section.find("ParameterName").value_or("");
  constexpr std::int64_t domain = 2;
  object.type = section.number("ObjectType", 0, 7) == domain ? Type::domain : type_of(section);
  object.access = access_of(section);
  object.standard = default_of(section, object.type, node_id);
  const bool whole = canopen::size_of(object.type) != 0 && canopen::size_of(object.type) <= 4 &&
                     object.type != Type::real;
  if (whole && (section.find("LowLimit") || section.find("HighLimit"))) {
    object.has_limits = true;
    const bool is_signed = canopen::is_signed(object.type);
    const auto signed_number = [&](std::string_view name, std::int64_t missing) {
      const std::int64_t value = section.number(name, node_id, missing);
      // A negative limit may be written as its bits.
      const auto bits = std::max(8U, unsigned{8} * canopen::size_of(object.type));
      const std::int64_t half = std::int64_t{1} << (bits - 1);
      return is_signed && half <= value && value < 2 * half ? value - 2 * half : value;
    };
    object.min = signed_number("LowLimit", is_signed ? -2147483648LL : 0);
    object.max = signed_number("HighLimit", is_signed ? 2147483647LL : 4294967295LL);
  }
  return object;
}

/// "1018" or "1018sub4"; nothing for other sections.
std::optional<Key> key_of(std::string_view name) {
  const auto hexadecimal = [](std::string_view text) -> std::optional<unsigned> {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
    const bool whole = error == std::errc{} && end == text.data() + text.size();
    return whole ? std::optional(value) : std::nullopt;
  };
  const std::size_t sub = name.find("sub");
  const std::optional<unsigned> index = hexadecimal(name.substr(0, sub));
  if (!index || *index > 0xFFFF || name.substr(0, sub).size() != 4) {
    return {};
  }
  if (sub == std::string_view::npos) {
    return Key{static_cast<std::uint16_t>(*index), 0};
  }
  const std::optional<unsigned> number = hexadecimal(name.substr(sub + 3));
  return number && *number <= 0xFF ? std::optional(Key{static_cast<std::uint16_t>(*index),
                                                       static_cast<std::uint8_t>(*number)})
                                   : std::nullopt;
}

}  // namespace

Eds parse_eds(std::string_view text, const std::string& file, std::uint8_t node_id) {
  const Sections sections = read_sections(text, file);
  Eds eds;
  if (const auto info = sections.find("deviceinfo"); info != sections.end()) {
    eds.vendor = info->second.find("VendorName").value_or("");
    eds.product = info->second.find("ProductName").value_or("");
    const auto number = [&](std::string_view key) {
      return static_cast<std::uint32_t>(info->second.number(key, node_id, 0));
    };
    eds.vendor_number = number("VendorNumber");
    eds.product_number = number("ProductNumber");
    eds.revision = number("RevisionNumber");
  }
  for (const auto& [name, section] : sections) {
    const std::optional<Key> key = key_of(name);
    const bool is_sub = name.find("sub") != std::string::npos;
    const std::int64_t kind = key ? section.number("ObjectType", node_id, 7) : 0;
    const bool has_value = is_sub || kind == 7 || kind == 2;
    if (key && has_value) {
      eds.objects.push_back(object_of(section, *key, node_id));
    }
  }
  std::ranges::sort(eds.objects, {}, &EdsObject::key);
  const auto twice = std::ranges::adjacent_find(eds.objects, {}, &EdsObject::key);
  if (twice != eds.objects.end()) {
    throw files::UserError(fmt::format("{}: object {:04X}h:{} stands there twice", file,
                                       twice->key.index, twice->key.sub));
  }
  if (eds.objects.empty()) {
    throw files::UserError(fmt::format("{}: has no objects", file));
  }
  return eds;
}

}  // namespace smaservo
