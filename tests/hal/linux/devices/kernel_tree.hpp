#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "hal/linux/system/files.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {

/// The kernel's files as far as they are needed.
class KernelTree {
 public:
  void put(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(folder_ / path).parent_path());
    std::ofstream(folder_ / path) << text;
  }
  std::string text(const std::string& path) const { return file_text(folder_ / path); }
  void remove(const std::string& path) const { std::filesystem::remove_all(folder_ / path); }
  std::string root() const { return folder_.path().string(); }
  hal::LinuxRoots roots() const { return {folder_ / "sys", folder_ / "dev", folder_ / "config"}; }

  void adc() const {
    const std::string base = "sys/bus/iio/devices/iio:device3/";
    put(base + "name", "ad7606\n");
    for (int i = 0; i < 3; ++i) {
      const std::string element = base + "scan_elements/in_voltage" + std::to_string(i);
      put(element + "_en", "1");
      put(element + "_index", std::to_string(i));
      put(element + "_type", "be:s16/16>>0\n");
    }
    put(base + "in_voltage_scale", "0.152587890\n");
    put(base + "buffer/enable", "1");
    put(base + "buffer/length", "2");
    put(base + "trigger/current_trigger", "");
    put("dev/iio:device3", std::string("\x00\x01\xFF\xFE\x00\x03\xFF\xFC", 8));
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace smaservo::test
