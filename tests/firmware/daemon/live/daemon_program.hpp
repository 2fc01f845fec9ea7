#pragma once

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/patience.hpp"
#include "tests/places.hpp"

namespace smaservo::test {

struct Ended {
  int status;
  std::string out, errors;

  bool exited_with(int code) const { return WIFEXITED(status) && WEXITSTATUS(status) == code; }
};

/// smaservod with these arguments, its output in files of a folder; `errors_to`, where it is given,
/// is its standard error output.
class Program {
 public:
  Program(const TemporaryFolder& folder, std::vector<std::string> arguments,
          const std::string& socket = "", int errors_to = -1)
      : out_(folder / "out"), errors_(folder / "errors") {
    process_ = fork();
    if (process_ == 0) {
      run(std::move(arguments), socket, errors_to);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() {
    if (process_ > 0) {
      ::kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
  }
  pid_t process() const { return process_; }
  void kill(int signal) const { ::kill(process_, signal); }
  Ended wait() {
    Ended ended{};
    waitpid(process_, &ended.status, 0);
    process_ = -1;
    ended.out = file_text(out_);
    ended.errors = file_text(errors_);
    return ended;
  }

 private:
  [[noreturn]] void run(std::vector<std::string> arguments, const std::string& socket,
                        int errors_to) const {
    arguments.insert(arguments.begin(), test::daemon_program());
    std::vector<char*> list;
    list.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) {
      list.push_back(argument.data());
    }
    list.push_back(nullptr);
    if (!socket.empty()) {
      setenv("NOTIFY_SOCKET", socket.c_str(), 1);
      setenv("WATCHDOG_USEC", "200000", 1);
    }
    if (std::freopen(out_.c_str(), "w", stdout) != nullptr &&
        std::freopen(errors_.c_str(), "w", stderr) != nullptr &&
        (errors_to < 0 || dup2(errors_to, STDERR_FILENO) >= 0)) {
      execv(list.front(), list.data());
    }
    _exit(127);
  }

  std::string out_, errors_;
  pid_t process_ = -1;
};

}  // namespace smaservo::test
