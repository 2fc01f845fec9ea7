#include <memory>

#include "host-sim/commands.hpp"
#include "host-sim/page/bridge.hpp"
#include "host-sim/page/servos/servo_source.hpp"
#include "host-sim/report/assets.hpp"

namespace smaservo::page {

void add_page_command(CLI::App& app) {
  CLI::App* page = app.add_subcommand(
      "page",
      "Serves a page that shows and tunes the servos of a bus, and what Foxglove connects to.");
  auto settings = std::make_shared<BridgeSettings>();
  auto can = std::make_shared<std::string>();
  settings->version = SMASERVO_VERSION;
  page->add_option("--can", *can, "can0, vcan0, ...; or udp, udp:GROUP[:PORT]")->required();
  page->add_option("--listen", settings->listen,
                   "ADDRESS:PORT; any other than 127.0.0.1 or [::1] asks for a token")
      ->capture_default_str();
  page->add_flag("--read-only", settings->read_only, "shows, and changes nothing but to stop");
  page->add_option("--token-file", settings->token_file,
                   "file with the token, made if it is missing; asks for it at any address");
  CLI::Option* certificate =
      page->add_option("--certificate", settings->certificate, "file in PEM, for https");
  CLI::Option* key = page->add_option("--key", settings->key, "its key, in PEM");
  certificate->needs(key);
  key->needs(certificate);
  page->add_option("--allow-origin", settings->origins,
                   "a page of another origin that may connect, as https://app.foxglove.dev")
      ->allow_extra_args(false);
  page->add_option("--clients", settings->clients, "browsers and other clients at once, at most")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  page->callback([=] {
    settings->page = report::page_html();
    run_bridge(*settings, [&] { return make_servo_source(*can); });
  });
}

}  // namespace smaservo::page
