// smaservo-table: writes the table of a spreadsheet or a MATLAB file as CSV, for the programs that
// read traces (hal/recording/foreign_table.hpp). It is a program of its own, since its libraries
// are large and read what others wrote: where one of them crashes, a message follows.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <limits>
#include <new>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

#include "hal/table/matlab.hpp"
#include "hal/table/spreadsheet.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::hal {
namespace {

/// No input takes longer or more than this.
void limit_resources() {
  constexpr rlim_t seconds = 60;
  constexpr auto bytes = static_cast<rlim_t>(
      std::min(std::uint64_t{4} << 30U, std::uint64_t{std::numeric_limits<rlim_t>::max()}));
  const auto limit = [](int what, rlim_t most) {
    rlimit old{};
    getrlimit(static_cast<__rlimit_resource>(what), &old);
    const rlimit now{std::min(old.rlim_max, most), old.rlim_max};
    setrlimit(static_cast<__rlimit_resource>(what), &now);
  };
  limit(RLIMIT_CPU, seconds);
  limit(RLIMIT_CORE, 0);
#ifndef SMASERVO_SANITIZED  // sanitizers need terabytes of addresses
  limit(RLIMIT_AS, bytes);
#else
  static_cast<void>(bytes);
#endif
}

void write_line(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& field : fields) {
    line += (&field == fields.data() ? "" : ",") + field;
  }
  put(line + '\n');
}

void write_spreadsheet(const char* path) {
  const ZipArchive archive(path);
  const Spreadsheet all = read_spreadsheet(archive);
  const SheetCells* const sheet = chosen_sheet(all.sheets);
  if (sheet == nullptr) {
    throw files::UserError(
        fmt::format("none of its {} sheets has a row of two numbers or more", all.sheets.size()));
  }
  put(fmt::format("sheet '{}'{} of an {} file\n", files::printable(sheet->name),
                  all.sheets.size() == 1 ? "" : fmt::format(", one of {},", all.sheets.size()),
                  all.program));
  sheet->write();
}

void write_matlab(const char* path) {
  const MatlabTable table = read_matlab(path);
  put(table.format + (table.left_out == 0   ? "\n"
                      : table.left_out == 1 ? ", of which an object of MATLAB was left out\n"
                                            : ", of which objects of MATLAB were left out\n"));
  for (const std::string& scalar : table.scalars) {
    put("# " + scalar + '\n');
  }
  std::vector<std::string> fields(table.columns.size());
  if (table.has_names) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      fields[i] = csv_field(table.columns[i].name);
    }
    write_line(fields);
  }
  for (std::size_t row = 0; row < table.rows; ++row) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      fields[i] = table.columns[i].at(row);
    }
    write_line(fields);
  }
}

void write_table(const char* path) {
  std::array<char, 4> head{};
  std::FILE* const file = std::fopen(path, "rbe");
  const std::size_t got = file == nullptr ? 0 : std::fread(head.data(), 1, head.size(), file);
  if (file != nullptr) {
    std::fclose(file);
  }
  const std::string_view begins(head.data(), got);
  if (begins == "PK\x03\x04") {
    write_spreadsheet(path);
  } else if (begins == "MATL") {
    write_matlab(path);
  } else {
    throw files::UserError(file == nullptr ? "cannot be read"
                                           : "is no spreadsheet and no MATLAB file");
  }
}

/// Returns what is wrong; "" if nothing is.
std::string problem_of(const char* path) {
  try {
    write_table(path);
    return std::fflush(stdout) == 0 ? "" : "the table cannot be written";
  } catch (const std::bad_alloc&) {
    return "takes more than 4 GiB of memory; save the table as CSV";
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace
}  // namespace smaservo::hal

int main(int count, char** arguments) {
  using namespace smaservo;
  if (count != 2) {
    files::print(
        "usage: smaservo-table FILE\n\nWrites the table of a spreadsheet or a MATLAB file as CSV, "
        "below a line that says what it is.\n",
        stderr);
    return 2;
  }
  hal::limit_resources();
  // Libraries complain of their own accord; what counts is the message at the end.
  const int said = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (said < 0 || nowhere < 0 || dup2(nowhere, STDERR_FILENO) < 0) {
    return 2;
  }
  const std::string problem = hal::problem_of(arguments[1]);
  dup2(said, STDERR_FILENO);
  if (!problem.empty()) {
    files::print(files::printable(problem) + '\n', stderr);
  }
  // Nothing more is left to libraries that may have damaged their memory.
  std::_Exit(problem.empty() ? 0 : 1);
}
