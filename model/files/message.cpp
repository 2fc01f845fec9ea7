#include "model/files/message.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fcntl.h>
#include <fmt/format.h>
#include <iterator>
#include <unistd.h>

namespace smaservo::files {
namespace {

constexpr char32_t no_symbol = 0xFFFFFFFF;

/// The first symbol of a text: a whole UTF-8 symbol, or one byte that begins none.
struct Symbol {
  std::string_view bytes;
  char32_t code;  ///< no_symbol: not UTF-8
};

Symbol first_symbol(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  if (first < 0x80) {
    return {text.substr(0, 1), first};
  }
  const Symbol none{text.substr(0, 1), no_symbol};
  const std::size_t size = first < 0xC2 || first > 0xF4 ? 1
                           : first < 0xE0               ? 2
                           : first < 0xF0               ? 3
                                                        : 4;
  if (size == 1 || text.size() < size) {
    return none;
  }
  char32_t code = first & (0x7FU >> size);
  for (const char c : text.substr(1, size - 1)) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) != 0x80) {
      return none;
    }
    code = code << 6U | (byte & 0x3FU);
  }
  // An overlong encoding is no symbol: some terminals would take it for the shorter one.
  constexpr std::array<char32_t, 5> least{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = 0xD800 <= code && code <= 0xDFFF;
  return code < least.at(size) || code > 0x10FFFF || surrogate ? none
                                                               : Symbol{text.substr(0, size), code};
}

/// Control characters of ASCII and Latin-1; characters that break a line, have no width or turn the
/// direction of writing; bytes that are no symbol.
bool is_unprintable(char32_t code) {
  const auto within = [&](char32_t low, char32_t high) { return low <= code && code <= high; };
  return code < 0x20 || within(0x7F, 0x9F) || code == 0x61C || within(0x200B, 0x200F) ||
         within(0x2028, 0x202E) || within(0x2060, 0x206F) || code == 0xFEFF ||
         within(0xFFF9, 0xFFFB) || within(0xE0000, 0xE007F) || code == no_symbol;
}

/// The bytes of a symbol as \xC2\x9B.
std::string bytes_of(const Symbol& symbol) {
  std::string out;
  for (const char byte : symbol.bytes) {
    fmt::format_to(std::back_inserter(out), "\\x{:02X}", static_cast<unsigned char>(byte));
  }
  return out;
}

/// A symbol as JSON writes it, in UTF-16.
std::string utf16_of(const Symbol& symbol) {
  if (symbol.code == no_symbol) {
    return "\\ufffd";
  }
  const auto code = static_cast<std::uint32_t>(symbol.code);
  return code < 0x10000 ? fmt::format("\\u{:04x}", code)
                        : fmt::format("\\u{:04x}\\u{:04x}", 0xD800 + ((code - 0x10000) >> 10U),
                                      0xDC00 + ((code - 0x10000) & 0x3FFU));
}

/// A symbol as TOML writes it.
std::string code_of(const Symbol& symbol) {
  const auto code = static_cast<std::uint32_t>(symbol.code);
  return symbol.code == no_symbol ? "\\ufffd"
         : code < 0x10000         ? fmt::format("\\u{:04x}", code)
                                  : fmt::format("\\U{:08x}", code);
}

/// Calls take(text) for each symbol, with its replacement if it is unprintable.
template <class Take>
void each(std::string_view text, std::string (*in_place_of)(const Symbol&), bool in_lines,
          const Take& take) {
  while (!text.empty()) {
    const Symbol symbol = first_symbol(text);
    text.remove_prefix(symbol.bytes.size());
    const bool stays = !is_unprintable(symbol.code) || (in_lines && symbol.code == '\n');
    stays ? take(symbol.bytes) : take(in_place_of(symbol));
  }
}

std::string whole(std::string_view text, std::string (*in_place_of)(const Symbol&), bool in_lines) {
  std::string out;
  each(text, in_place_of, in_lines, [&](std::string_view part) { out += part; });
  return out;
}

/// Greatest number of bytes that are kept of the printable head and of a text's tail. What lies
/// between is not read, so that a file of gigabytes costs no time.
constexpr std::size_t longest_head = 3000;
constexpr std::size_t longest_tail = 900;

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  std::size_t head = 0;
  // A text that fits is kept whole; of a longer one, the head and the tail are kept.
  each(text.substr(0, longest_message + 1), bytes_of, false, [&](std::string_view part) {
    out += part;
    head = out.size() <= longest_head ? out.size() : head;
  });
  if (text.size() <= longest_message && out.size() <= longest_message) {
    return out;
  }
  out.resize(head);
  std::string_view rest = text.substr(text.size() - std::min(longest_tail, text.size()));
  while (!rest.empty() && (static_cast<unsigned char>(rest.front()) & 0xC0U) == 0x80) {
    rest.remove_prefix(1);
  }
  std::string end;
  each(rest, bytes_of, false, [&](std::string_view part) { end += part; });
  std::size_t cut = end.size() - std::min(longest_tail, end.size());
  while (cut < end.size() && (static_cast<unsigned char>(end[cut]) & 0xC0U) == 0x80) {
    ++cut;
  }
  return fmt::format("{} [... {} bytes in all ...] {}", out, text.size(), end.substr(cut));
}

std::string printable_lines(std::string_view text) {
  return whole(text, bytes_of, true);
}

std::string printable_json(std::string_view document) {
  return whole(document, utf16_of, true);
}

std::string printable_toml(std::string_view text) {
  return whole(text, code_of, false);
}

void hold_standard_descriptors() {
  int held = 0;
  do {
    held = open("/dev/null", O_RDONLY);
  } while (0 <= held && held <= STDERR_FILENO);
  if (STDERR_FILENO < held) {
    close(held);
  }
}

void complain(std::string_view program, std::string_view text) noexcept {
  try {
    // The line is written by one call, so that lines of several threads do not mix.
    const std::string line = fmt::format("{}: {}\n", program, printable(text));
    std::fwrite(line.data(), 1, line.size(), stderr);
  } catch (...) {
    std::fputs("no memory for a message\n", stderr);
  }
}

void print(std::string_view text, std::FILE* file) {
  const std::string all = printable_lines(text);
  std::fwrite(all.data(), 1, all.size(), file);
}

void redraw(std::string_view line) {
  const std::string text = "\r\033[K" + printable(line);
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void clear_terminal() {
  std::fputs("\033[H\033[J", stdout);
}

}  // namespace smaservo::files
