#pragma once
// Step files on the microcontroller, read over semihosting.

#include <algorithm>
#include <array>
#include <optional>

#include "hal/cortex-m/semihosting.hpp"
#include "tests/mcu/step_file.hpp"

namespace smaservo::mcu {

/// The image in a step file as the first of two slots.
class ImageSlot {
 public:
  ImageSlot(const semihosting::File& file, std::size_t bytes) : file_(file), bytes_(bytes) {}

  bool read(unsigned slot, std::size_t offset, std::span<std::byte> to) const {
    if (slot != 0 || bytes_ < offset + to.size()) {
      return false;
    }
    return file_.seek(sizeof(StepFileHeader) + offset) && file_.read(to) == to.size();
  }
  static bool erase(unsigned /*slot*/) { return false; }
  static bool write(unsigned /*slot*/, std::size_t /*offset*/,
                    std::span<const std::byte> /*from*/) {
    return false;
  }
  static bool sync() { return false; }

 private:
  const semihosting::File& file_;
  std::size_t bytes_;
};
static_assert(Storage<ImageSlot>);

class StepReader {
 public:
  explicit StepReader(std::string_view name) : file_(name, semihosting::Open::read) {
    if (!file_.is_open() || file_.read(std::as_writable_bytes(std::span(&header_, 1))) == 0 ||
        header_.magic != StepFileHeader::own_magic) {
      header_ = {};
    }
  }
  ~StepReader() { file_.close(); }
  StepReader(const StepReader&) = delete;
  StepReader& operator=(const StepReader&) = delete;
  StepReader(StepReader&&) = delete;
  StepReader& operator=(StepReader&&) = delete;

  const Ranges& ranges() const { return header_.ranges; }

  template <class S>
  std::optional<Settings<S>> settings() {
    ImageSlot slot(file_, header_.image_bytes);
    const Loaded<S> loaded = load_settings<S>(slot);
    file_.seek(sizeof header_ + header_.image_bytes);
    left_ = header_.steps;
    at_ = block_.size();
    return loaded.reason == LoadReason::none ? std::nullopt : std::optional(loaded.settings);
  }

  /// Behind settings(); null at the end.
  const StepRecord* next() {
    if (left_ == 0) {
      return nullptr;
    }
    if (at_ == block_.size()) {
      file_.read(std::as_writable_bytes(
          std::span(block_).first(std::min<std::size_t>(left_, block_.size()))));
      at_ = 0;
    }
    --left_;
    return &block_.at(at_++);
  }

 private:
  semihosting::File file_;
  StepFileHeader header_{};
  std::array<StepRecord, 256> block_{};
  std::size_t at_ = block_.size();
  std::uint32_t left_ = 0;
};

}  // namespace smaservo::mcu
