#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <string_view>

namespace smaservo::files {

/// A file that appears under its name only when it is complete: it is written as
/// PATH.HOST.PROCESS.part and then renamed. After commit() a loss of power destroys neither the
/// content nor the name. Partial files of killed programs are removed; partial files that another
/// program is writing are kept. "-" is the standard output; devices and pipes are written directly.
/// Throws UserError if the file cannot be written.
class OutputFile {
 public:
  explicit OutputFile(std::string path);
  ~OutputFile();  ///< removes the file if it was not committed
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

 private:
  [[noreturn]] void fail(const char* what) const;

  std::string path_;
  std::string target_;  ///< the file that will be replaced
  std::string beside_;  ///< the partial file; empty when the target is written directly
  std::FILE* file_ = nullptr;
};

/// The name of the partial file of `path`: computers that share a folder have equal numbers of
/// processes. Of the host's name it has the first label, or as much of its end as a file name has
/// room for.
std::string partial_path(const std::string& path, std::string host, long process);

/// Removes partial files of killed programs from a folder, of those whose name is wanted. Kept are
/// those that a program holds locked, and, since a lock of another computer is not seen on every
/// file system, those that were written to within the last hour.
void remove_left_overs(const std::string& folder,
                       const std::function<bool(const std::string& name)>& wanted);

/// Makes the list of files durable in the folder that contains `path`: files created, renamed or
/// removed. False if this fails; errno says why.
bool sync_folder_of(const std::string& path);

/// Creates the folder that an option names, if it does not exist. Throws UserError if files cannot
/// be written there.
void prepare_folder(const char* option, const std::string& folder);

}  // namespace smaservo::files
