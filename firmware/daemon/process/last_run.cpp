#include "firmware/daemon/process/last_run.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <sys/file.h>
#include <unistd.h>

#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

std::string text_of(const std::string& path) {
  const std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Reads a mark: "STATE BOOT", padded with spaces. The state is one word, after a crash for example
/// "crashed:SIGNAL:heated".
LastRun parse(const std::string& text, const std::string& boot) {
  std::istringstream words(text);
  std::string state;
  std::string its_boot;
  words >> state >> its_boot;
  LastRun last;
  if (state.empty()) {
    return last;
  }
  if (state == "ended") {
    last.ending = Ending::clean;
  } else if (state.starts_with("crashed:")) {
    last.ending = Ending::crashed;
    const char* const number = state.c_str() + std::strlen("crashed:");
    std::from_chars(number, state.c_str() + state.size(), last.signal);
    last.heated = state.ends_with(":heated");
  } else {
    last.ending = its_boot == boot ? Ending::killed : Ending::power;
    last.heated = state != "idle";  // a damaged mark counts as heated
  }
  return last;
}

}  // namespace

std::string describe(const LastRun& last) {
  const std::string when = last.heated ? "while the wire was heated" : "while the wire was off";
  std::string text;
  switch (last.ending) {
    case Ending::none:
      return "there was no run before";
    case Ending::clean:
      return "the last run ended cleanly";
    case Ending::crashed:
      text = fmt::format("the last run crashed with signal {} ({}) {}", last.signal,
                         strsignal(last.signal), when);
      break;
    case Ending::killed:
      text = fmt::format("the last run was killed {}", when);
      break;
    case Ending::power:
      text = fmt::format("the machine lost its power or was reset {}", when);
      break;
  }
  return last.result.empty()
             ? text
             : fmt::format("{}; service result: {}", text, files::printable(last.result));
}

RunMark::RunMark(const std::string& folder, const std::string& boot) : boot_(boot) {
  files::prepare_folder("--settings", folder);
  const std::string path = folder + "/run";
  const std::string result = folder + "/service-result";
  file_ = hal::Descriptor(open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644));
  if (file_.number() >= 0 && flock(file_.number(), LOCK_EX | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    throw files::UserError(fmt::format("{}: another smaservod runs with this folder", folder));
  }
  last_ = parse(text_of(path), boot);
  if (last_.unclean()) {
    last_.result = text_of(result);
    while (!last_.result.empty() && last_.result.back() == '\n') {
      last_.result.pop_back();
    }
    std::ofstream history(folder + "/history", std::ios::app);
    history << fmt::format("{:%FT%TZ} {}\n", fmt::gmtime(std::time(nullptr)), describe(last_));
  }
  std::error_code none;
  std::filesystem::remove(result, none);
  // The folder is synchronised as well: if a loss of power removed the mark, there would seem to
  // have been no run.
  if (file_.number() < 0 || !set(State::idle) || !files::sync_folder_of(path)) {
    throw files::UserError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
  }
}

RunMark::Block RunMark::block(const std::string& state) const {
  Block block{};
  block.fill(' ');
  const std::string text = state + " " + boot_;
  std::copy_n(text.begin(), std::min(text.size(), block.size() - 1), block.begin());
  block.back() = '\n';
  return block;
}

bool RunMark::set(State state) {
  constexpr std::array names{"idle", "heated", "ended"};
  const Block bytes = block(names.at(static_cast<std::size_t>(state)));
  return pwrite(file_.number(), bytes.data(), bytes.size(), 0) ==
             static_cast<ssize_t>(bytes.size()) &&
         fdatasync(file_.number()) == 0;
}

bool RunMark::follow(bool heated, std::int64_t now_ns) {
  constexpr std::int64_t idle_after_ns = 1'000'000'000;
  cold_since_ns_ = heated ? now_ns : cold_since_ns_;
  const bool wanted = heated || (marked_heated_ && now_ns - cold_since_ns_ < idle_after_ns);
  if (wanted == marked_heated_) {
    return true;
  }
  marked_heated_ = wanted;
  return set(wanted ? State::heated : State::idle);
}

RunMark::Block RunMark::crash_block(int signal, bool heated) const {
  return block(fmt::format("crashed:{}:{}", signal, heated ? "heated" : "off"));
}

std::string boot_id() {
  std::string text = text_of("/proc/sys/kernel/random/boot_id");
  std::erase(text, '\n');
  return text.empty() ? "unknown" : text;
}

void keep_service_result(const std::string& folder, const std::string& result) {
  files::OutputFile file(folder + "/service-result");
  file.write(result + "\n");
  file.commit();
}

}  // namespace smaservo::daemon
