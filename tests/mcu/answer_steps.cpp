// Fills in what the steps of files give on this machine, summed in the order of a processor without
// vector registers:
//   answer_steps FILE...

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "tests/mcu/step_file.hpp"

namespace smaservo::mcu {
namespace {

/// A whole step file.
class StepFile {
 public:
  explicit StepFile(const std::string& path) : path_(path) {
    std::ifstream file(path, std::ios::binary);
    put(file, header_);
    image_.resize(file ? header_.image_bytes : 0);
    file.read(reinterpret_cast<char*>(image_.data()), static_cast<std::streamsize>(image_.size()));
    records_.resize(file ? header_.steps : 0);
    for (StepRecord& record : records_) {
      put(file, record);
    }
    good_ = file.good() && header_.magic == StepFileHeader::own_magic;
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

  bool answer() {
    const Loaded<float> loaded = load_settings<float>(*this);
    if (!good_ || loaded.reason == LoadReason::none) {
      return false;
    }
    const Prepared<float> prepared = prepare(loaded.settings);
    Device<float>::State state = Device<float>::start();
    for (StepRecord& record : records_) {
      record.outputs = step(prepared, state, record.inputs);
    }
    header_.ranges = ranges();
    return true;
  }
  bool save() const {
    std::ofstream file(path_, std::ios::binary);
    const auto all = [&](const void* from, std::size_t bytes) {
      file.write(static_cast<const char*>(from), static_cast<std::streamsize>(bytes));
    };
    all(&header_, sizeof header_);
    all(image_.data(), image_.size());
    all(records_.data(), records_.size() * sizeof(StepRecord));
    return file.flush().good();
  }

 private:
  template <class T>
  static void put(std::ifstream& from, T& to) {
    from.read(reinterpret_cast<char*>(&to), sizeof to);
  }
  Ranges ranges() const {
    Ranges all{};
    for (std::size_t i = 0; i < all.size(); ++i) {
      float least = std::numeric_limits<float>::infinity(), greatest = -least;
      for (const StepRecord& record : records_) {
        const float number = std::bit_cast<StepNumbers>(record.outputs).number[i];
        least = std::isfinite(number) ? std::fmin(least, number) : least;
        greatest = std::isfinite(number) ? std::fmax(greatest, number) : greatest;
      }
      // Of what stands still, its size.
      all[i] = least < greatest ? greatest - least : std::fmax(std::abs(greatest), 1e-30F);
    }
    return all;
  }

  std::string path_;
  StepFileHeader header_{};
  std::vector<std::byte> image_;
  std::vector<StepRecord> records_;
  bool good_ = false;
};

}  // namespace
}  // namespace smaservo::mcu

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    smaservo::mcu::StepFile file(argv[i]);
    if (!file.answer() || !file.save()) {
      std::fprintf(stderr, "%s: is no step file, or can not be written\n", argv[i]);
      return 1;
    }
  }
  return argc > 1 ? 0 : 2;
}
