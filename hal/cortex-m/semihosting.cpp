#include "hal/cortex-m/semihosting.hpp"

#include <array>

namespace smaservo::semihosting {
namespace {

enum class Call : std::uint32_t {
  open = 0x01,
  close = 0x02,
  write_text = 0x04,
  write = 0x05,
  read = 0x06,
  seek = 0x0A,
  size = 0x0C,
  command_line = 0x15,
  exit_extended = 0x20,
};

using Words = std::array<std::uintptr_t, 3>;

std::int32_t call(Call which, const void* argument) {
  register std::uintptr_t r0 asm("r0") = static_cast<std::uintptr_t>(which);
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<std::int32_t>(r0);
}

std::uintptr_t word(const void* pointer) {
  return reinterpret_cast<std::uintptr_t>(pointer);
}

}  // namespace

File::File(std::string_view name, Open how) {
  const Words words{word(name.data()), static_cast<std::uintptr_t>(how), name.size()};
  handle_ = call(Call::open, words.data());
}

std::size_t File::read(std::span<std::byte> to) const {
  const Words words{static_cast<std::uintptr_t>(handle_), word(to.data()), to.size()};
  const auto missing = static_cast<std::size_t>(call(Call::read, words.data()));
  return missing <= to.size() ? to.size() - missing : 0;
}

bool File::write(std::span<const std::byte> from) const {
  const Words words{static_cast<std::uintptr_t>(handle_), word(from.data()), from.size()};
  return call(Call::write, words.data()) == 0;
}

bool File::seek(std::size_t position) const {
  const Words words{static_cast<std::uintptr_t>(handle_), position, 0};
  return call(Call::seek, words.data()) == 0;
}

std::size_t File::size() const {
  const Words words{static_cast<std::uintptr_t>(handle_), 0, 0};
  const std::int32_t bytes = call(Call::size, words.data());
  return bytes < 0 ? 0 : static_cast<std::size_t>(bytes);
}

void File::close() {
  const Words words{static_cast<std::uintptr_t>(handle_), 0, 0};
  call(Call::close, words.data());
  handle_ = -1;
}

void print(const char* text) {
  call(Call::write_text, text);
}

void print(std::string_view text) {
  std::array<char, 64> part{};
  while (!text.empty()) {
    const std::size_t size = text.copy(part.data(), part.size() - 1);
    part.at(size) = '\0';
    print(part.data());
    text.remove_prefix(size);
  }
}

std::string_view arguments(std::span<char> buffer) {
  Words words{word(buffer.data()), buffer.size(), 0};
  if (call(Call::command_line, words.data()) != 0) {
    return {};
  }
  // The program's path may contain blanks, so the arguments begin after ".elf ".
  constexpr std::string_view behind = ".elf ";
  const std::string_view line(buffer.data(), words[1]);
  const std::size_t at = line.find(behind);
  return at == std::string_view::npos ? std::string_view{} : line.substr(at + behind.size());
}

void leave(int status) {
  constexpr std::uintptr_t application_exit = 0x20026;
  const Words words{application_exit, static_cast<std::uintptr_t>(status), 0};
  for (;;) {
    call(Call::exit_extended, words.data());
  }
}

}  // namespace smaservo::semihosting
