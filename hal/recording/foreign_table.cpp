#include "hal/recording/foreign_table.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "hal/recording/start_program.hpp"
#include "model/files/error.hpp"
#include "model/files/installed.hpp"

namespace smaservo::hal {
namespace {

constexpr const char* table_packages = SMASERVO_TABLE_PACKAGES;
constexpr std::size_t longest_description = 8000;

/// A pipe whose ends are not the standard ones, which a caller may have closed.
std::pair<int, int> open_pipe() {
  std::array<int, 2> ends{};
  bool good = pipe2(ends.data(), O_CLOEXEC) == 0;
  for (int& end : ends) {
    if (good && end <= STDERR_FILENO) {
      const int moved = fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
      close(end);
      end = moved;
      good = moved >= 0;
    }
  }
  if (!good) {
    throw files::UserError(std::strerror(errno));
  }
  return {ends[0], ends[1]};
}

std::size_t read_some(int file, char* to, std::size_t room) {
  ssize_t got = 0;
  do {
    got = ::read(file, to, room);
  } while (got < 0 && errno == EINTR);
  if (got < 0) {
    throw files::UserError(std::strerror(errno));
  }
  return static_cast<std::size_t>(got);
}

/// Starts the program on a file, with an environment of its own. Returns 0 or an error.
int start(const std::string& program, int file, int output, int errors, pid_t& child) {
  // HDF5 takes no lock, which some network drives refuse, and loads no other code.
  std::string locale = "LC_ALL=C";
  std::string locks = "HDF5_USE_FILE_LOCKING=FALSE";
  std::string plugins = "HDF5_PLUGIN_PRELOAD=::";
  std::array<char*, 4> environment{locale.data(), locks.data(), plugins.data(), nullptr};
  return start_program({.program = program,
                        .arguments = {"/proc/self/fd/0"},
                        .input = file,
                        .output = output,
                        .errors = errors,
                        .environment = environment.data()},
                       child);
}

/// What a status of the program's end means, but for its own messages.
std::string meaning_of_end(int status, const std::string& said) {
  constexpr int not_started = 127;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return signal == SIGXCPU || signal == SIGKILL
               ? "it takes more than a minute or more memory than there is; save it as CSV"
               : "the library that reads it crashed, so the file is probably damaged; save it as "
                 "CSV";
  }
  if (WEXITSTATUS(status) == not_started) {
    return fmt::format(
        "the libraries that read it are not all installed ({}); install Debian's packages {}", said,
        table_packages);
  }
  return said.empty() ? fmt::format("the program that reads it ended with {}; save it as CSV",
                                    WEXITSTATUS(status))
                      : said;
}

}  // namespace

bool ForeignTable::begins(std::string_view head) {
  constexpr std::array<std::string_view, 3> magics{"PK\x03\x04", "MATLAB 5", "MATLAB 7"};
  return std::ranges::any_of(magics, [&](auto magic) { return head.starts_with(magic); });
}

std::string ForeignTable::program() {
  return files::installed("smaservo-table");
}

ForeignTable::ForeignTable(int file, const std::string& program) : program_(program) {
  const auto [output, to_output] = open_pipe();
  output_ = output;
  const auto [errors, to_errors] = open_pipe();
  errors_ = errors;
  const int failed = start(program, file, to_output, to_errors, child_);
  close(to_output);
  close(to_errors);
  if (failed != 0) {
    child_ = -1;
    end_child();
    throw files::UserError(
        fmt::format("is read by the program smaservo-table, which cannot be started ({}: {}); it "
                    "belongs to the package smaservo, and to the build as target smaservo-table",
                    program, std::strerror(failed)));
  }
  try {
    std::array<char, 4096> part{};
    std::size_t end = std::string::npos;
    while (end == std::string::npos && head_.size() < longest_description) {
      const std::size_t got = read_output(part.data(), part.size());
      head_.append(part.data(), got);
      end = head_.find('\n');
      if (got == 0) {
        throw files::UserError("smaservo-table wrote nothing");
      }
    }
    description_ = head_.substr(0, end);
    head_.erase(0, end == std::string::npos ? end : end + 1);
  } catch (...) {
    end_child();
    throw;
  }
}

ForeignTable::~ForeignTable() {
  end_child();
}

void ForeignTable::end_child() {
  if (child_ > 0) {
    kill(child_, SIGKILL);
    while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
  }
  for (int* const file : {&output_, &errors_}) {
    if (*file >= 0) {
      close(*file);
      *file = -1;
    }
  }
}

std::size_t ForeignTable::read(char* to, std::size_t room) {
  if (!head_.empty()) {
    const std::size_t part = head_.copy(to, room);
    head_.erase(0, part);
    return part;
  }
  return read_output(to, room);
}

std::size_t ForeignTable::read_output(char* to, std::size_t room) {
  const std::size_t got = output_ < 0 ? 0 : read_some(output_, to, room);
  if (got == 0) {
    finish();
  }
  return got;
}

/// After the end of the output: whether it was the end of the table.
void ForeignTable::finish() {
  if (child_ < 0) {
    return;
  }
  std::array<char, 4096> part{};
  std::string said;
  for (std::size_t got = 1; got > 0;) {
    got = read_some(errors_, part.data(), part.size());
    said.append(part.data(),
                std::min(got, longest_description - std::min(said.size(), longest_description)));
  }
  said.erase(std::min(said.find('\n'), said.size()));
  int status = 0;
  while (waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  child_ = -1;
  end_child();
  if (status != 0) {
    throw files::UserError(meaning_of_end(status, said));
  }
}

}  // namespace smaservo::hal
