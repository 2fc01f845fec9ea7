#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <zip.h>

namespace smaservo::hal {

/// The files inside a zip archive. What is damaged or encrypted throws files::UserError.
class ZipArchive {
 public:
  using Take = std::function<void(std::string_view part)>;

  explicit ZipArchive(const char* path);

  bool has(const std::string& name) const;
  /// Gives the content of the file in parts.
  void read(const std::string& name, const Take& take) const;
  /// The beginning of a file, at most `longest` bytes.
  std::string beginning(const std::string& name, std::size_t longest) const;

 private:
  std::unique_ptr<zip_t, void (*)(zip_t*)> zip_;
};

}  // namespace smaservo::hal
