#include "hal/recording/mcap/row_object.hpp"

#include <array>
#include <charconv>
#include <fmt/format.h>

#include "hal/recording/utf8.hpp"

namespace smaservo::hal::mcap {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The length of the number at the beginning; 0 if there is none.
std::size_t number_length(std::string_view text) {
  std::size_t at = 0;
  const auto digits = [&] {
    const std::size_t from = at;
    while (at < text.size() && is_digit(text[at])) {
      ++at;
    }
    return at - from;
  };
  const auto is = [&](char a, char b) {
    return at < text.size() && (text[at] == a || text[at] == b);
  };
  at += std::size_t{is('-', '-')};
  if (is('0', '0')) {
    ++at;
  } else if (digits() == 0) {
    return 0;
  }
  if (is('.', '.')) {
    ++at;
    if (digits() == 0) {
      return 0;
    }
  }
  if (is('e', 'E')) {
    ++at;
    at += std::size_t{is('-', '+')};
    if (digits() == 0) {
      return 0;
    }
  }
  return at;
}

/// The length of the character at `at` if it is well-formed UTF-8 of two bytes or more, else 0
/// (RFC 3629: no surrogates, nothing longer than it must be).
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U;
  };
  const unsigned first = byte(0);
  const std::size_t length = first < 0xC2   ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  const unsigned low = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned high = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (length == 0 || byte(1) < low || byte(1) > high) {
    return 0;
  }
  for (std::size_t i = 2; i < length; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xBF) {
      return 0;
    }
  }
  return length;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20;
}

}  // namespace

bool is_json_number(std::string_view text) {
  return !text.empty() && number_length(text) == text.size();
}

bool put_json_text(std::string& to, std::string_view text) {
  to += '"';
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (static_cast<unsigned char>(c) >= 0x80) {
      const std::size_t length = utf8_length(text, at);
      if (length == 0) {
        return false;
      }
      to += text.substr(at, length);
      at += length;
      continue;
    }
    if (c == '"' || c == '\\') {
      to += '\\';
      to += c;
    } else if (is_control(c)) {
      to += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      to += c;
    }
    ++at;
  }
  to += '"';
  return true;
}

bool RowObject::fail(std::string_view what) {
  problem_ = fmt::format("at {}: {}", at_, what);
  return false;
}

void RowObject::skip_spaces() {
  while (at_ < json_.size() &&
         std::string_view(" \t\n\r").find(json_[at_]) != std::string_view::npos) {
    ++at_;
  }
}

bool RowObject::accept(char wanted) {
  skip_spaces();
  if (at_ < json_.size() && json_[at_] == wanted) {
    ++at_;
    return true;
  }
  return false;
}

/// Reads what stands between members; false at the end or if there is a problem.
bool RowObject::begin_member() {
  if (!began_) {
    began_ = true;
    if (!accept('{')) {
      return fail("must be a JSON object");
    }
    if (!accept('}')) {
      return true;
    }
  } else if (!accept('}')) {
    return accept(',') || fail("a comma or } is missing");
  }
  skip_spaces();
  return at_ == json_.size() ? false : fail("something stands behind the object");
}

bool RowObject::next(Member& member) {
  if (!problem_.empty() || !begin_member()) {
    return false;
  }
  skip_spaces();
  if (!text(member.name, name_)) {
    return false;
  }
  if (!accept(':')) {
    return fail("a colon is missing");
  }
  skip_spaces();
  return value(member.value);
}

bool RowObject::value(std::string_view& to) {
  const char first = at_ < json_.size() ? json_[at_] : '\0';
  switch (first) {
    case '"':
      return text(to, text_);
    case 'n':
      to = "";
      return word("null");
    case 't':
      to = "1";
      return word("true");
    case 'f':
      to = "0";
      return word("false");
    case '{':
    case '[':
      return fail("an object or a list; a row has numbers, texts, true, false and null");
    default:
      return number(to);
  }
}

bool RowObject::number(std::string_view& to) {
  const std::size_t length = number_length(json_.substr(at_));
  if (length == 0) {
    return fail("is no value");
  }
  to = json_.substr(at_, length);
  at_ += length;
  return true;
}

bool RowObject::word(std::string_view wanted) {
  if (!json_.substr(at_).starts_with(wanted)) {
    return fail("is no value");
  }
  at_ += wanted.size();
  return true;
}

bool RowObject::text(std::string_view& to, std::string& room) {
  if (at_ >= json_.size() || json_[at_] != '"') {
    return fail("a text in quotes is missing");
  }
  const std::size_t from = ++at_;
  bool plain = true;  // the text contains no escapes
  while (at_ < json_.size() && json_[at_] != '"') {
    const char c = json_[at_];
    if (c == '\\') {
      if (plain) {
        room = json_.substr(from, at_ - from);
        plain = false;
      }
      ++at_;
      if (!escape(room)) {
        return false;
      }
      continue;
    }
    const std::size_t length = static_cast<unsigned char>(c) < 0x80 ? std::size_t{!is_control(c)}
                                                                    : utf8_length(json_, at_);
    if (length == 0) {
      return fail(is_control(c) ? "a control character in a text" : "is no UTF-8");
    }
    if (!plain) {
      room += json_.substr(at_, length);
    }
    at_ += length;
  }
  if (at_ == json_.size()) {
    return fail("a text without its end");
  }
  to = plain ? json_.substr(from, at_ - from) : std::string_view(room);
  ++at_;
  return true;
}

bool RowObject::escape(std::string& to) {
  constexpr std::string_view names = "\"\\/bfnrt";
  constexpr std::string_view meant = "\"\\/\b\f\n\r\t";
  const char c = at_ < json_.size() ? json_[at_] : '\0';
  if (const std::size_t which = c == '\0' ? std::string_view::npos : names.find(c);
      which != std::string_view::npos) {
    to += meant[which];
    ++at_;
    return true;
  }
  std::uint32_t code = 0;
  if (c != 'u') {
    return fail("an escape that JSON does not have");
  }
  if (!four_digits(code)) {
    return false;
  }
  if (code >= 0xD800 && code < 0xDC00) {
    std::uint32_t low = 0;
    if (!json_.substr(at_).starts_with("\\u")) {
      return fail("half of a character");
    }
    ++at_;
    if (!four_digits(low)) {
      return false;
    }
    if (low < 0xDC00 || low > 0xDFFF) {
      return fail("half of a character");
    }
    code = 0x10000 + ((code - 0xD800) << 10U) + (low - 0xDC00);
  } else if (code >= 0xDC00 && code <= 0xDFFF) {
    return fail("half of a character");
  }
  put_utf8(to, code);
  return true;
}

/// Reads u and four hexadecimal digits.
bool RowObject::four_digits(std::uint32_t& to) {
  const std::string_view digits = json_.substr(at_).substr(1, 4);
  const char* const start = digits.data();
  const char* const stop = start + digits.size();
  const auto [end, error] = std::from_chars(start, stop, to, 16);
  if (digits.size() != 4 || error != std::errc{} || end != stop || digits[0] == '-') {
    return fail("four hexadecimal digits are missing");
  }
  at_ += 5;
  return true;
}

}  // namespace smaservo::hal::mcap
