#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace smaservo::hal {

/// The two slots of firmware/parameters/store/store.hpp as files FOLDER/settings.0 and
/// FOLDER/settings.1. Writes are collected until sync(), which writes a new file, makes it durable,
/// renames it and makes the folder durable. A slot without a file counts as erased.
class FileStore {
 public:
  static constexpr std::size_t slot_size = 65536;

  explicit FileStore(std::string folder) : folder_(std::move(folder)) {}

  // The members that Storage requires.
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
