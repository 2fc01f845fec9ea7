#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <sys/types.h>

namespace smaservo::hal {

/// The table of a spreadsheet or a MATLAB file, as CSV. Another program reads the file,
/// smaservo-table (hal/table), since its libraries are large, and one of them may crash on a
/// damaged file. All functions that read throw files::UserError, which does not name the file.
class ForeignTable {
 public:
  /// Whether a file that begins so is one of these.
  static bool begins(std::string_view head);
  /// Where smaservo-table is: in ../lib/smaservo beside the folder of this program, or, of tests, a
  /// folder further up; else, for programs of others, in lib/smaservo of /usr/local or of /usr,
  /// where the package has it. The first of these if it is nowhere.
  static std::string program();

  /// `file` is a regular file, from whose beginning is read; it stays the caller's.
  explicit ForeignTable(int file, const std::string& program = ForeignTable::program());
  ~ForeignTable();
  ForeignTable(const ForeignTable&) = delete;
  ForeignTable& operator=(const ForeignTable&) = delete;

  /// "MATLAB 5 file", "sheet 'Run 3', one of 3, of an Excel file".
  const std::string& description() const { return description_; }
  /// Whether the lines are the rows of a sheet, counted from 1.
  bool is_sheet() const { return description_.starts_with("sheet"); }
  /// Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t room);

 private:
  std::size_t read_output(char* to, std::size_t room);
  void finish();
  void end_child();

  std::string program_;
  pid_t child_ = -1;  ///< -1: it has ended
  int output_ = -1, errors_ = -1;
  std::string description_;
  std::string head_;  ///< read behind the description, and not given yet
};

}  // namespace smaservo::hal
