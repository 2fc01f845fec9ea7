#include "model/files/installed.hpp"

namespace smaservo::files {

std::filesystem::path installed(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path below = fs::path("lib/smaservo") / name;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  fs::path beside = folder.parent_path() / below;
  for (const fs::path& place : {beside, folder.parent_path().parent_path() / below,
                                fs::path("/usr/local") / below, fs::path("/usr") / below}) {
    if (fs::exists(place, error)) {
      return place;
    }
  }
  return beside;
}

}  // namespace smaservo::files
