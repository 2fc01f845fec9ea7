#pragma once
// A step file in memory, on a machine that has room for it.

#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "tests/mcu/step_file.hpp"

namespace smaservo::mcu {

class WholeStepFile {
 public:
  explicit WholeStepFile(const std::string& path) : path_(path) {
    std::ifstream file(path, std::ios::binary);
    put(file, header);
    image_.resize(file ? header.image_bytes : 0);
    file.read(reinterpret_cast<char*>(image_.data()), static_cast<std::streamsize>(image_.size()));
    records.resize(file ? header.steps : 0);
    for (StepRecord& record : records) {
      put(file, record);
    }
    good_ = file.good() && header.magic == StepFileHeader::own_magic;
  }

  // A Storage with the image in its first slot.
  bool read(unsigned slot, std::size_t offset, std::span<std::byte> to) const {
    if (slot != 0 || image_.size() < offset + to.size()) {
      return false;
    }
    std::memcpy(to.data(), image_.data() + offset, to.size());
    return true;
  }
  static bool erase(unsigned /*slot*/) { return false; }
  static bool write(unsigned /*slot*/, std::size_t /*at*/, std::span<const std::byte> /*from*/) {
    return false;
  }
  static bool sync() { return false; }

  /// None: that is no step file.
  template <class S>
  std::optional<Settings<S>> settings() {
    const Loaded<S> loaded = load_settings<S>(*this);
    return good_ && loaded.reason != LoadReason::none ? std::optional(loaded.settings)
                                                      : std::nullopt;
  }
  bool save() const {
    std::ofstream file(path_, std::ios::binary);
    const auto all = [&](const void* from, std::size_t bytes) {
      file.write(static_cast<const char*>(from), static_cast<std::streamsize>(bytes));
    };
    all(&header, sizeof header);
    all(image_.data(), image_.size());
    all(records.data(), records.size() * sizeof(StepRecord));
    return file.flush().good();
  }

  StepFileHeader header{};
  std::vector<StepRecord> records;

 private:
  template <class T>
  static void put(std::ifstream& from, T& to) {
    from.read(reinterpret_cast<char*>(&to), sizeof to);
  }

  std::string path_;
  std::vector<std::byte> image_;
  bool good_ = false;
};

}  // namespace smaservo::mcu
