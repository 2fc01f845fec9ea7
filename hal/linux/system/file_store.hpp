#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace smaservo::hal {

/// The two slots of firmware/parameters/store.hpp as files FOLDER/settings.0 and FOLDER/settings.1.
/// What was written is gathered, and in force with sync(): written beside, made durable, renamed,
/// and the folder made durable. A slot without a file is an erased one.
class FileStore {
 public:
  static constexpr std::size_t slot_size = 65536;

  explicit FileStore(std::string folder) : folder_(std::move(folder)) {}

  // Storage.
  bool read(unsigned slot, std::size_t offset, std::span<std::byte> to);
  bool erase(unsigned slot);
  bool write(unsigned slot, std::size_t offset, std::span<const std::byte> from);
  bool sync();

 private:
  struct Slot {
    std::vector<std::byte> bytes;
    bool dirty = false;
  };

  std::string path(unsigned slot) const;
  bool replace(unsigned slot);

  std::string folder_;
  std::array<Slot, 2> slots_{};
};

}  // namespace smaservo::hal
