#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace smaservo::hal {

/// A column of numbers of a MATLAB file, as text.
struct MatlabColumn {
  std::string name;
  std::function<std::string(std::size_t row)> at;
};

/// What of a MATLAB file is a table: its vectors of one length, and the matrix that has as many
/// rows or columns.
struct MatlabTable {
  std::string format;                ///< "MATLAB 5 file"
  std::vector<std::string> scalars;  ///< "fs = 1000"
  std::size_t left_out = 0;          ///< objects, which only MATLAB reads
  std::vector<MatlabColumn> columns;
  bool has_names = true;
  std::size_t rows = 0;
  std::vector<std::shared_ptr<void>> kept;  ///< what the columns read from
};

/// Reads a file of MATLAB 5 to 7.3. Where nothing fits the files::UserError lists the variables.
MatlabTable read_matlab(const char* path);

}  // namespace smaservo::hal
