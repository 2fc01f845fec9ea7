#include "host-sim/evaluate/observer_program.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <limits>
#include <poll.h>
#include <string_view>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "hal/linux/system/descriptor.hpp"
#include "hal/recording/start_program.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/replay/observers.hpp"
#include "host-sim/temporary_folder.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::evaluate {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t longest_answer = 1000;  ///< bytes of a line
constexpr std::size_t longest_quoted = 300;
/// A greater strain at the start is one in percent. Later ones may be those of an observer that is
/// lost.
constexpr double farthest_start = 0.5;
/// After each exchange, so that a program that writes each line by itself does not wake this thread
/// for each. Pipes hold more than a program answers in this time.
constexpr std::chrono::milliseconds rest{1};

/// Blocks SIGPIPE for this thread: a program that closes its input early must not end host-sim.
class NoPipeSignal {
 public:
  NoPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoPipeSignal() {
    constexpr timespec at_once{};
    while (sigtimedwait(&pipe_, nullptr, &at_once) < 0 && errno == EINTR) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  sigset_t pipe_{}, before_{};
};

[[noreturn]] void fail_with_errno(const char* what) {
  throw files::UserError(fmt::format("--observer-program: {}: {}", what, std::strerror(errno)));
}

struct Pipe {
  hal::Descriptor to_read, to_write;
};

/// The end that stays here does not block.
Pipe open_pipe(bool written_here) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    fail_with_errno("a pipe");
  }
  Pipe pipe{hal::Descriptor(ends[0]), hal::Descriptor(ends[1])};
  if (fcntl(written_here ? ends[1] : ends[0], F_SETFL, O_NONBLOCK) != 0) {
    fail_with_errno("a pipe");
  }
  return pipe;
}

constexpr int unknown_end = -1;

/// How long a conversation may take to see that one has come.
constexpr std::chrono::milliseconds signal_patience{200};

/// The running program, in a process group of its own.
class Child {
 public:
  Child(const std::string& program, const std::string& wire_file) {
    Pipe input = open_pipe(true);
    Pipe output = open_pipe(false);
    Pipe errors = open_pipe(false);
    const int failed = hal::start_program({.program = program,
                                           .arguments = {wire_file},
                                           .input = input.to_read.number(),
                                           .output = output.to_write.number(),
                                           .errors = errors.to_write.number(),
                                           .environment = environ,
                                           .own_group = true},
                                          number_);
    if (failed != 0) {
      throw files::UserError(fmt::format(
          "--observer-program {}: cannot be started: {}; a script must begin with a line that "
          "names its interpreter, such as #!/usr/bin/env python3",
          program, std::strerror(failed)));
    }
    running_ = hal::Descriptor(static_cast<int>(syscall(SYS_pidfd_open, number_, 0U)));
    if (running_.number() < 0) {
      const int why = errno;
      wait();
      errno = why;
      fail_with_errno("waiting for it");
    }
    input_ = std::move(input.to_write);
    output_ = std::move(output.to_read);
    errors_ = std::move(errors.to_read);
  }
  ~Child() { wait(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  int input() const { return input_.number(); }
  int output() const { return output_.number(); }
  int errors() const { return errors_.number(); }
  int running() const { return running_.number(); }  ///< is readable when the program has ended
  void close_input() { input_ = hal::Descriptor(); }
  void close_output() { output_ = hal::Descriptor(); }
  void close_errors() { errors_ = hal::Descriptor(); }

  /// Ends what still runs of the program and of what it has started. Returns the status of
  /// waitpid(); unknown_end if somebody else has taken it.
  int wait() {
    if (number_ > 0) {
      // Until waitpid() nobody else gets the number. A program that has ended keeps its status.
      kill(-number_, SIGKILL);
      while (waitpid(number_, &status_, 0) < 0 && errno == EINTR) {
      }
      number_ = -1;
    }
    return status_;
  }

 private:
  pid_t number_ = -1;
  int status_ = unknown_end;
  hal::Descriptor input_, output_, errors_, running_;
};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

/// False if it is no finite number.
bool read_number(std::string_view text, double& value) {
  text = trimmed(text);
  text.remove_prefix(text.starts_with('+') ? 1 : 0);
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const auto [at, error] = std::from_chars(begin, end, value);
  return error == std::errc{} && at == end && std::isfinite(value);
}

bool read_answer(std::string_view line, ProgramAnswer& answer) {
  const std::size_t comma = line.find(',');
  answer.strain_sd = std::numeric_limits<double>::quiet_NaN();
  return read_number(line.substr(0, comma), answer.strain) &&
         (comma == std::string_view::npos ||
          (read_number(line.substr(comma + 1), answer.strain_sd) && answer.strain_sd >= 0));
}

std::string table(const std::vector<simulate::SimulatedRow>& rows) {
  std::string text = "time_s,current_A,voltage_V,load_N\n";
  for (const simulate::SimulatedRow& row : rows) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{}\n", row.time_s, row.current_A,
                   row.voltage_V, row.load_N);
  }
  return text;
}

/// One run of the program.
class Conversation {
 public:
  Conversation(const std::string& program, const std::string& wire_file, std::string input,
               std::size_t rows, const std::string& run)
      : where_(fmt::format("--observer-program {}: {}", program, run)),
        input_(std::move(input)),
        rows_(rows),
        child_(program, wire_file) {}

  std::vector<ProgramAnswer> answers(std::chrono::milliseconds patience) {
    auto due = Clock::now() + patience;
    for (bool ended = false; !ended;) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now());
      if (left.count() <= 0) {
        child_.wait();
        read_errors();
        fail(
            fmt::format("neither reads nor answers for {:g} s, after {}{}; it must read until its "
                        "input ends, and then end",
                        std::chrono::duration<double>(patience).count(), reached(), complaint()));
      }
      std::array<pollfd, 4> files{{{child_.input(), POLLOUT, 0},
                                   {child_.output(), POLLIN, 0},
                                   {child_.errors(), POLLIN, 0},
                                   {child_.running(), POLLIN, 0}}};
      if (EndBySignal::came()) {
        fail("is ended with this program");
      }
      const int ready = poll(files.data(), files.size(),
                             static_cast<int>(std::min(left, signal_patience).count()));
      if (ready < 0 && errno != EINTR) {
        fail_with_errno("waiting for it");
      }
      if (ready <= 0) {
        continue;
      }
      ended = files[3].revents != 0;
      const bool given = files[0].revents != 0 && give();
      const bool taken = files[1].revents != 0 && read_answers();
      if (files[2].revents != 0) {
        read_errors();
      }
      if (given || taken) {
        due = Clock::now() + patience;
        std::this_thread::sleep_for(rest);
      }
    }
    return finish();
  }

 private:
  /// Whether anything was written.
  bool give() {
    const ssize_t written = write(child_.input(), input_.data() + given_, input_.size() - given_);
    if (written < 0) {
      // EPIPE: it reads no further. Whether that is a mistake is seen from its answers.
      if (errno == EPIPE) {
        child_.close_input();
      } else if (errno != EAGAIN && errno != EINTR) {
        fail_with_errno("writing to it");
      }
      return false;
    }
    given_ += static_cast<std::size_t>(written);
    if (given_ == input_.size()) {
      child_.close_input();
    }
    return true;
  }

  /// Reads once. Nothing if there is nothing now; closes at the end of the file.
  template <class Close>
  std::string_view read_some(int file, const Close& close_it) {
    ssize_t got = -1;
    if (file >= 0) {
      do {
        got = read(file, part_.data(), part_.size());
      } while (got < 0 && errno == EINTR);
      if (got == 0) {
        close_it();
      } else if (got < 0 && errno != EAGAIN) {
        fail_with_errno("reading from it");
      }
    }
    return {part_.data(), got > 0 ? static_cast<std::size_t>(got) : 0};
  }

  /// Whether anything was read.
  bool read_answers() {
    const std::string_view part = read_some(child_.output(), [this] { child_.close_output(); });
    line_ += part;
    std::size_t from = 0;
    for (std::size_t to = line_.find('\n'); to != std::string::npos; to = line_.find('\n', from)) {
      take(std::string_view(line_).substr(from, to - from));
      from = to + 1;
    }
    line_.erase(0, from);
    if (line_.size() > longest_answer) {
      ++lines_;
      refuse(line_);
    }
    return !part.empty();
  }

  /// Reads once, as much as a pipe holds, and keeps the end.
  void read_errors() {
    errors_ += read_some(child_.errors(), [this] { child_.close_errors(); });
    if (errors_.size() > part_.size()) {
      errors_.erase(0, errors_.size() - part_.size());
    }
  }

  void take(std::string_view line) {
    ++lines_;
    line = trimmed(line);
    if (lines_ == 1 && line.starts_with("strain")) {
      return;
    }
    if (answers_.size() == rows_) {
      if (line.empty()) {
        return;
      }
      fail(
          fmt::format("writes more lines than the {} rows that it is given; it must write one for "
                      "each row, and before these only a header that begins with \"strain\"",
                      rows_));
    }
    ProgramAnswer answer{};
    if (!read_answer(line, answer)) {
      refuse(line);
    }
    if (answers_.empty() && std::abs(answer.strain) > farthest_start) {
      fail(
          fmt::format("its first strain is {}, beyond {:g} % of the length; a strain is a share of "
                      "the length, as 0.031 where it is 3.1 %",
                      answer.strain, 100 * farthest_start));
    }
    if (!answers_.empty() &&
        std::isnan(answers_.front().strain_sd) != std::isnan(answer.strain_sd)) {
      fail(
          fmt::format("line {} of its output is \"{}\"; either all lines of a run must have a "
                      "standard deviation, or none",
                      lines_, files::printable(line)));
    }
    answers_.push_back(answer);
  }

  [[noreturn]] void refuse(std::string_view line) const {
    fail(
        fmt::format("line {} of its output is \"{}\"; it must be the strain, or the strain and "
                    "its standard deviation, in finite numbers such as 0.031 or 0.031,0.0004",
                    lines_, files::printable(line.substr(0, longest_quoted))));
  }

  /// After its end.
  std::vector<ProgramAnswer> finish() {
    const int status = child_.wait();
    while (read_answers()) {
    }
    read_errors();
    if (status == unknown_end) {
      fail("has ended, but nobody knows how; start host-sim where SIGCHLD is not ignored");
    }
    if (WIFSIGNALED(status)) {
      const char* const meaning = sigdescr_np(WTERMSIG(status));
      fail(fmt::format("is ended by signal {} ({}), after {}{}", WTERMSIG(status),
                       meaning == nullptr ? "unknown" : meaning, reached(), complaint()));
    }
    if (WEXITSTATUS(status) != 0) {
      fail(fmt::format("ends with {}, after {}{}; it must end with 0", WEXITSTATUS(status),
                       reached(), complaint()));
    }
    if (!line_.empty()) {
      take(std::exchange(line_, ""));
    }
    if (answers_.size() < rows_) {
      fail(fmt::format("ends after {}{}; it must write one line for each row, until its input ends",
                       reached(), complaint()));
    }
    return std::move(answers_);
  }

  std::string reached() const { return fmt::format("{} of {} answers", answers_.size(), rows_); }

  /// The last line that it has written to its standard error.
  std::string complaint() const {
    std::string_view text = errors_;
    text = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
    const std::size_t before = text.find_last_of('\n');
    text.remove_prefix(before == std::string_view::npos ? 0 : before + 1);
    return text.empty()
               ? ""
               : fmt::format("; it says \"{}\"", files::printable(text.substr(0, longest_quoted)));
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw files::UserError(fmt::format("{}: {}", where_, what));
  }

  std::string where_;
  std::string input_;
  std::size_t given_ = 0;  ///< bytes of the input that the program's pipe has taken
  std::size_t rows_;
  Child child_;
  std::array<char, 65536> part_{};
  std::string line_;       ///< of its output, what no end of line has followed yet
  std::size_t lines_ = 0;  ///< of its output
  std::string errors_;     ///< the end of its standard error
  std::vector<ProgramAnswer> answers_;
};

}  // namespace

void check_observer_program(const std::string& program) {
  std::error_code ignored;
  const char* mistake = nullptr;
  if (!std::filesystem::exists(program, ignored)) {
    mistake = "there is no such file; give the path of a program";
  } else if (!std::filesystem::is_regular_file(program, ignored)) {
    mistake = "is no file; give the path of a program";
  } else if (access(program.c_str(), X_OK) != 0) {
    mistake =
        "may not be executed; make it executable (chmod +x), a script with a first line such as "
        "#!/usr/bin/env python3";
  }
  if (mistake != nullptr) {
    throw files::UserError(fmt::format("--observer-program {}: {}", program, mistake));
  }
}

std::vector<std::string> observer_program_names(const std::vector<std::string>& programs) {
  const auto file_name = [](const std::string& program) {
    return std::filesystem::path(program).filename().string();
  };
  const auto whole_path = [](const std::string& program) {
    return std::filesystem::absolute(program).lexically_normal();
  };
  std::vector<std::string> names;
  for (const std::string& program : programs) {
    if (std::ranges::count(programs, whole_path(program), whole_path) > 1) {
      throw files::UserError(fmt::format("--observer-program {}: is given twice", program));
    }
    const std::string name = file_name(program);
    const bool taken =
        std::ranges::count(programs, name, file_name) > 1 ||
        std::ranges::count(replay::observer_kinds(), name, &replay::ObserverKind::name) > 0;
    names.push_back(files::printable(!taken ? name : program == name ? "./" + name : program));
  }
  return names;
}

std::vector<ProgramAnswer> ask_observer_program(const std::string& program,
                                                const Wire<double>& wire,
                                                const std::vector<simulate::SimulatedRow>& rows,
                                                const std::string& run,
                                                std::chrono::milliseconds patience) {
  const TemporaryFolder folder;
  const std::string wire_file = (folder / "wire.toml").string();
  std::ofstream file(wire_file, std::ios::binary);
  file << files::to_toml_si({"wire", wire, {{"all", "host-sim evaluate"}}});
  file.close();
  if (!file) {
    throw files::UserError(fmt::format("{}: cannot be written", wire_file));
  }
  const NoPipeSignal no_pipe_signal;
  return Conversation(program, wire_file, table(rows), rows.size(), run).answers(patience);
}

}  // namespace smaservo::evaluate
