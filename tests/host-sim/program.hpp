#pragma once
// The real program, run as a process.

#include <fcntl.h>
#include <spawn.h>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "tests/hal/replay/temporary_folder.hpp"
#include "tests/places.hpp"

namespace smaservo::test {

struct Finished {
  int status = -1;  ///< what it returned; 128 and the signal's number where one ended it
  std::string out, err;
};

/// A run of host-sim in a folder of its own.
class Program {
 public:
  using Texts = std::vector<std::string>;

  const TemporaryFolder& folder() const { return folder_; }

  Finished run(const Texts& arguments, const std::string& input = "") {
    const std::string in = streams_.write("in", input);
    return run_between(arguments, in, streams_ / "out");
  }

  Finished run_between(const Texts& arguments, const std::string& in, const std::string& out) {
    return wait(start(arguments, open(in.c_str(), O_RDONLY | O_CLOEXEC), out));
  }

  /// Takes the descriptor that becomes standard input.
  pid_t start(const Texts& arguments, int input, const std::string& out) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    out_ = out;
    constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
    const std::string err = terminal.empty() ? streams_ / "err" : terminal;
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_.c_str(), flags, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), flags, 0600);
    posix_spawn_file_actions_addchdir_np(&actions, folder_.path().c_str());
    Texts texts = arguments;
    if (launcher.empty()) {
      texts.insert(texts.begin(), "host-sim");
    } else {
      texts.insert(texts.begin(), launcher.begin(), launcher.end());
    }
    std::vector<char*> argv = pointers(texts);
    std::vector<char*> envp = pointers(environment);
    pid_t child = 0;
    const std::string program = launcher.empty() ? test::host_sim_program() : launcher.front();
    const int failed =
        posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), envp.data());
    posix_spawn_file_actions_destroy(&actions);
    close(input);
    if (failed != 0) {
      throw std::runtime_error("cannot run " + test::host_sim_program());
    }
    return child;
  }

  Finished wait(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            out_.starts_with("/dev/") ? "" : file_text(out_), file_text(streams_ / "err")};
  }

  std::string terminal;  ///< terminal for its errors instead of a file; empty: none
  Texts launcher;        ///< what is run instead, and its first arguments; empty: host-sim itself
  Texts environment{"PATH=/usr/bin:/bin", "LC_ALL=C.UTF-8"};

 private:
  static std::vector<char*> pointers(Texts& texts) {
    std::vector<char*> all;
    for (std::string& text : texts) {
      all.push_back(text.data());
    }
    all.push_back(nullptr);
    return all;
  }

  TemporaryFolder folder_;   ///< working folder of the program
  TemporaryFolder streams_;  ///< outputs of the program
  std::string out_;
};

}  // namespace smaservo::test
