#include "hal/table/zip_archive.hpp"

#include <array>
#include <fmt/format.h>

#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

zip_t* open_zip(const char* path) {
  int code = 0;
  zip_t* const zip = zip_open(path, ZIP_RDONLY, &code);
  if (zip == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string said = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw files::UserError("the zip archive is damaged or was cut off: " + said);
  }
  return zip;
}

}  // namespace

ZipArchive::ZipArchive(const char* path) : zip_(open_zip(path), zip_discard) {}

bool ZipArchive::has(const std::string& name) const {
  return zip_name_locate(zip_.get(), name.c_str(), 0) >= 0;
}

void ZipArchive::read(const std::string& name, const Take& take) const {
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
      zip_fopen(zip_.get(), name.c_str(), 0), zip_fclose);
  if (!file) {
    throw files::UserError(
        fmt::format("{} in the zip archive: {}", name, zip_strerror(zip_.get())));
  }
  std::array<char, std::size_t{1} << 16> part{};
  for (;;) {
    const zip_int64_t got = zip_fread(file.get(), part.data(), part.size());
    if (got < 0) {
      throw files::UserError(
          fmt::format("{} in the zip archive is damaged: {}", name, zip_file_strerror(file.get())));
    }
    if (got == 0) {
      return;
    }
    take({part.data(), static_cast<std::size_t>(got)});
  }
}

std::string ZipArchive::beginning(const std::string& name, std::size_t longest) const {
  std::string text;
  read(name, [&](std::string_view part) {
    text += part.substr(0, longest - std::min(longest, text.size()));
  });
  return text;
}

}  // namespace smaservo::hal
