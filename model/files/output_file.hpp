#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace smaservo::files {

/// A file that appears under its name only when it is complete: written beside as
/// PATH.PROCESS.part, then renamed. After commit() a loss of power takes neither the content nor
/// the name. What a killed program left beside is removed; what another one is writing is not.
/// "-" is standard output; devices and pipes are written as they are. Throws UserError when it
/// cannot be written.
class OutputFile {
 public:
  explicit OutputFile(std::string path);
  ~OutputFile();  ///< removes what was not committed
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

 private:
  [[noreturn]] void fail(const char* what) const;

  std::string path_;
  std::string target_;  ///< what will be replaced
  std::string beside_;  ///< what is being written; empty when it is written in place
  std::FILE* file_ = nullptr;
};

/// Makes durable which files the folder of this one has: what was created, renamed or removed.
/// False: it fails, errno says why.
bool sync_folder_of(const std::string& path);

/// Makes the folder that an option names where it is missing. Throws UserError when files cannot
/// be written there.
void prepare_folder(const char* option, const std::string& folder);

}  // namespace smaservo::files
