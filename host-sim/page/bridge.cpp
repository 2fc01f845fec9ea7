#include "host-sim/page/bridge.hpp"

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <pthread.h>
#include <thread>
#include <unistd.h>

#include "host-sim/page/server/server.hpp"
#include "host-sim/page/token_file.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

sigset_t ending_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

/// The host by which a browser finds the server. If it listens on the whole network there is no
/// single address, but the machine has a name.
std::string host_of(const Listen& listen) {
  if (listen.address != "0.0.0.0" && listen.address != "::") {
    return listen.text();
  }
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return fmt::format("{}:{}", files::printable(name.data()), listen.port);
}

/// Whether the output goes to the journal of a service, which other users may read.
bool is_journal() {
  return std::getenv("JOURNAL_STREAM") != nullptr;  // NOLINT(concurrency-mt-unsafe): at the start
}

void print_address(const BridgeSettings& settings, const AccessRules& rules,
                   const std::string& token_file) {
  std::string url = fmt::format("{}://{}/", settings.certificate.empty() ? "http" : "https",
                                host_of(rules.listen));
  if (!rules.token.empty()) {
    url += is_journal() ? fmt::format("?token=(what {} holds)", files::printable(token_file))
                        : "?token=" + rules.token;
  }
  files::print(url + "\n");
  std::fflush(stdout);
  if (!rules.listen.loopback && settings.certificate.empty()) {
    files::complain("host-sim",
                    "page: without --certificate whoever reads along on the network sees the token "
                    "and may use it");
  }
}

/// Ends the server at a signal; runs in a thread of its own.
class EndBySignal {
 public:
  explicit EndBySignal(Server& server)
      : thread_([&server] {
          const sigset_t signals = ending_signals();
          int which = 0;
          sigwait(&signals, &which);
          server.stop();
        }) {}
  ~EndBySignal() {
    // If the server ended by itself, no signal was sent, so this sends one. It is blocked and is
    // received by sigwait.
    // NOLINTNEXTLINE(bugprone-bad-signal-to-kill-thread)
    pthread_kill(thread_.native_handle(), SIGTERM);
    thread_.join();
  }
  EndBySignal(const EndBySignal&) = delete;
  EndBySignal& operator=(const EndBySignal&) = delete;

 private:
  std::thread thread_;
};

}  // namespace

void run_bridge(const BridgeSettings& settings,
                const std::function<std::unique_ptr<Source>()>& make_source) {
  if (settings.certificate.empty() != settings.key.empty()) {
    throw files::ConfigError("--certificate and --key: one needs the other");
  }
  AccessRules rules{
      .listen = parse_listen(settings.listen), .token = "", .origins = settings.origins};
  std::string token_file = settings.token_file;
  if (!rules.listen.loopback || !token_file.empty()) {
    if (token_file.empty()) {
      token_file = default_token_file();
    }
    rules.token = token_of(token_file);
  }
  // All threads inherit this signal mask.
  const sigset_t signals = ending_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  const std::unique_ptr<Source> source = make_source();
  Server server({.access = rules,
                 .read_only = settings.read_only,
                 .certificate = settings.certificate,
                 .key = settings.key,
                 .clients = settings.clients,
                 .patience_s = settings.patience_s,
                 .units = settings.units,
                 .version = settings.version,
                 .page = settings.page},
                *source);
  rules.listen.port = server.port();
  const EndBySignal end(server);
  print_address(settings, rules, token_file);
  server.run();
}

}  // namespace smaservo::page
