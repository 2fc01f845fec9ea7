#include "firmware/daemon/bus/bus_files.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>

#include "firmware/daemon/bus/kept_settings.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

/// The content of a file; empty if it does not exist. An empty file, or one that cannot be read, is
/// a damaged image.
Image read_image(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const Image image{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::error_code unknown;
  const bool is_missing = !file.is_open() && !std::filesystem::exists(path, unknown) && !unknown;
  return image.empty() && !is_missing ? Image(1) : image;
}

/// Removes a file. Returns the error; empty if the file does not exist any more, even after a loss
/// of power.
std::string remove_durably(const std::string& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) {
    return fmt::format("{}: cannot be removed: {}", path, error.message());
  }
  return files::sync_folder_of(path)
             ? ""
             : fmt::format("{}: a loss of power may bring it back: {}", path, std::strerror(errno));
}

/// Returns the error; empty if the file has been written durably.
std::string write_image(const std::string& path, const Image& image) {
  try {
    files::OutputFile file(path);
    file.write({reinterpret_cast<const char*>(image.data()),  // NOLINT(*-reinterpret-cast): bytes
                image.size()});
    file.commit();
    return {};
  } catch (const files::UserError& error) {
    return error.what();
  }
}

}  // namespace

Image BusFiles::image() const {
  return folder_.empty() ? Image{} : read_image(image_path());
}

std::string BusFiles::keep(const StoreJob& job, bool image_lost) const {
  if (folder_.empty()) {
    return "there is no folder to store in; give one with --settings";
  }
  using enum canopen::Request;
  std::string problem;
  switch (job.request) {
    case store_all:
      problem = store_settings(folder_, job.settings);
      return problem.empty() ? write_image(image_path(), job.image) : problem;
    case store_application:
      return store_settings(folder_, job.settings);
    case store_lss:
      // The image holds all stored objects. If it were written now, it would hold defaults in place
      // of the lost ones, and the next start would take these defaults for stored values.
      return image_lost ? image_path() + " is damaged: store (1010h) or restore (1011h) first"
                        : write_image(image_path(), job.image);
    case store_communication:
      return write_image(image_path(), job.image);
    case restore_all:
      problem = remove_durably(image_path());
      return problem.empty() ? forget_settings(folder_) : problem;
    case restore_application:
      return forget_settings(folder_);
    case restore_communication:
      return remove_durably(image_path());
    default:
      return "the request is not supported";
  }
}

}  // namespace smaservo::daemon
