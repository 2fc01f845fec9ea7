#pragma once
// Arm's semihosting, version 2: files, texts and the exit of a program that runs in an emulator or
// under a debugger. A program on a board without a debugger cannot use it.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace smaservo::semihosting {

enum class Open : std::uint32_t { read = 1, write = 5, append = 9 };

/// A file or named pipe of the host. The characters of `name` must be followed by a zero byte.
class File {
 public:
  File() = default;
  File(std::string_view name, Open how);
  bool is_open() const { return handle_ >= 0; }
  /// Number of bytes read; fewer than asked for at the file's end.
  std::size_t read(std::span<std::byte> to) const;
  /// Whether all bytes were written.
  bool write(std::span<const std::byte> from) const;
  bool seek(std::size_t position) const;
  /// Size in bytes.
  std::size_t size() const;
  void close();

 private:
  std::int32_t handle_ = -1;
};

/// Prints a text up to its terminating zero.
void print(const char* text);
void print(std::string_view text);

/// The arguments that follow the program, a *.elf, on the emulator's command line, separated by one
/// blank; empty if they do not fit into `buffer`.
std::string_view arguments(std::span<char> buffer);

[[noreturn]] void leave(int status);

}  // namespace smaservo::semihosting
