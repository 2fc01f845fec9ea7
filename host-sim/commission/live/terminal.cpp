#include "host-sim/commission/live/terminal.hpp"

#include <array>
#include <cerrno>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "model/files/message.hpp"

namespace smaservo::commission {
namespace {

/// A terminal of 80 columns breaks a line that fills it, and the next one is then not drawn over
/// it.
constexpr std::size_t drawn_columns = 79;

}  // namespace

TerminalPerson::TerminalPerson(bool questions)
    : is_there_(questions && isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1),
      draws_(isatty(STDERR_FILENO) == 1) {}

void TerminalPerson::end_line() {
  if (open_) {
    files::print("\n", stderr);
    open_ = false;
  }
}

void TerminalPerson::show(std::string_view line) {
  if (draws_) {
    files::redraw(line.substr(0, drawn_columns));
    open_ = true;
  }
}

void TerminalPerson::say(std::string_view line) {
  end_line();
  files::complain("host-sim", line);
}

void TerminalPerson::ask(std::string_view question, std::int64_t /*until_us*/) {
  end_line();
  input_.clear();
  tcflush(STDIN_FILENO, TCIFLUSH);
  files::print(question, stderr);
  std::fflush(stderr);
  open_ = true;
}

std::optional<std::string> TerminalPerson::typed() {
  for (std::size_t end = input_.find('\n'); is_there_; end = input_.find('\n')) {
    if (end != std::string::npos) {
      std::string line = input_.substr(0, end);
      input_.erase(0, end + 1);
      open_ = false;  // the terminal has shown the line's end
      return line;
    }
    pollfd waiting{STDIN_FILENO, POLLIN, 0};
    if (poll(&waiting, 1, 0) <= 0) {
      return {};
    }
    std::array<char, 256> part{};
    const ssize_t size = read(STDIN_FILENO, part.data(), part.size());
    if (size > 0) {
      input_.append(part.data(), static_cast<std::size_t>(size));
    } else if (size == 0 || (errno != EINTR && errno != EAGAIN)) {
      is_there_ = false;
    } else {
      return {};
    }
  }
  return {};
}

}  // namespace smaservo::commission
