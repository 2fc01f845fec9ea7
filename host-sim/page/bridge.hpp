#pragma once
// The whole bridge: a server with a source behind it, from reading the options to the end by a
// signal.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/page/source.hpp"

namespace smaservo::page {

struct BridgeSettings {
  std::string listen = "127.0.0.1:8765";
  bool read_only = false;
  std::string token_file;  ///< "": the default file, if a token is needed
  std::string certificate, key;
  std::vector<std::string> origins;
  unsigned clients = 8;
  unsigned patience_s = 4;
  std::string units = "bench";  ///< the page's first choice of units: "bench" or "si"
  std::string version;
  std::string_view page;
};

/// Makes the source, prints the address to open, and serves until SIGINT or SIGTERM; heat that the
/// source has switched on is off on return. Throws UserError.
void run_bridge(const BridgeSettings& settings,
                const std::function<std::unique_ptr<Source>()>& make_source);

}  // namespace smaservo::page
