#pragma once
// Files, texts and the exit of a program that runs in an emulator or under a debugger: Arm's
// semihosting, version 2. A board of its own has no use for it.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace smaservo::semihosting {

enum class Open : std::uint32_t { read = 1, write = 5, append = 9 };

/// A file or named pipe of the host. Names end with a zero, behind the view.
class File {
 public:
  File() = default;
  File(std::string_view name, Open how);
  bool is_open() const { return handle_ >= 0; }
  /// Bytes that came; fewer than asked for at the end.
  std::size_t read(std::span<std::byte> to) const;
  /// Whether all of it was written.
  bool write(std::span<const std::byte> from) const;
  bool seek(std::size_t position) const;
  /// In bytes.
  std::size_t size() const;
  void close();

 private:
  std::int32_t handle_ = -1;
};

/// Up to a zero.
void print(const char* text);
void print(std::string_view text);

/// The arguments that the emulator was given behind the program, a *.elf, with one blank between
/// them; empty where they do not fit.
std::string_view arguments(std::span<char> buffer);

[[noreturn]] void leave(int status);

}  // namespace smaservo::semihosting
