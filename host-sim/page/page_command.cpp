#include "host-sim/page/page_command.hpp"

#include <memory>

#include "host-sim/page/bridge.hpp"
#include "host-sim/page/servos/servo_source.hpp"
#include "host-sim/report/assets.hpp"

namespace smaservo::page {
namespace {

void add_bus_options(CLI::App& page, ServoOptions& servos) {
  page.add_option("--can", servos.can, "can0, vcan0, ...; or udp, udp:GROUP[:PORT]")->required();
  page.add_option("--access-key", servos.key, "key of an access level of the servos (2003h)");
  page.add_option("--sync", servos.sync_s,
                  "period of SYNC, s, for live values at this rate; 0: they are polled")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  page.add_option(
          "--signals", servos.sync_signals,
          "up to 8 live values that come by SYNC: SI names, such as wire_temperature_K, with or "
          "without `live.`")
      ->delimiter(',');
  page.add_option("--watch", servos.watch_s,
                  "longest silence of this program before a servo ends its heat, s")
      ->capture_default_str()
      ->check(CLI::Range(0.6, 60.0));
  page.add_option("--timeout", servos.timeout_s, "longest wait for an answer of a servo, s")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 60.0));
}

void add_server_options(CLI::App& page, BridgeSettings& server) {
  page.add_option("--listen", server.listen,
                  "ADDRESS:PORT; any other than 127.0.0.1 or [::1] asks for a token")
      ->capture_default_str();
  page.add_flag("--read-only", server.read_only, "shows, and changes nothing but to stop");
  page.add_option("--token-file", server.token_file,
                  "file with the token, made if it is missing; asks for it at any address");
  CLI::Option* certificate =
      page.add_option("--certificate", server.certificate, "file in PEM, for https");
  CLI::Option* key = page.add_option("--key", server.key, "its key, in PEM");
  certificate->needs(key);
  key->needs(certificate);
  page.add_option("--allow-origin", server.origins,
                  "a page of another origin that may connect, as https://app.foxglove.dev")
      ->allow_extra_args(false);
  page.add_option("--clients", server.clients, "browsers and other clients at once, at most")
      ->capture_default_str()
      ->check(CLI::Range(1, 64));
  page.add_option("--units", server.units,
                  "units until someone chooses others in the page: bench is degC, MPa, mA, mW, um, "
                  "mm/s, %; si is K, Pa, A, W, m, m/s, 1")
      ->capture_default_str()
      ->check(CLI::IsMember({"bench", "si"}));
  page.add_option("--patience", server.patience_s,
                  "longest silence of a browser before it is closed, which ends its heat, s")
      ->capture_default_str()
      ->check(CLI::Range(4, 60));
}

}  // namespace

void add_page_command(CLI::App& app) {
  CLI::App* page = app.add_subcommand(
      "page", "Shows and tunes the servos of a bus in browsers, and in Foxglove.");
  auto servos = std::make_shared<ServoOptions>();
  auto server = std::make_shared<BridgeSettings>();
  server->version = SMASERVO_VERSION;
  add_bus_options(*page, *servos);
  add_server_options(*page, *server);
  page->callback([=] {
    server->page = report::page_html();
    servos->read_only = server->read_only;
    run_bridge(*server, [&] { return make_servo_source(*servos); });
  });
}

}  // namespace smaservo::page
