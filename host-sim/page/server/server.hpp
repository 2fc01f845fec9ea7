#pragma once
// Serves the page and its WebSocket over HTTP, by libwebsockets, in the thread that calls run().

#include <memory>
#include <string>
#include <string_view>

#include "host-sim/page/access.hpp"
#include "host-sim/page/source.hpp"

namespace smaservo::page {

struct ServerSettings {
  AccessRules access;
  bool read_only = false;
  std::string certificate, key;  ///< PEM files; "": no TLS
  unsigned clients = 8;          ///< greatest number of WebSocket clients
  unsigned patience_s = 4;       ///< longest silence of a client before it is closed, 4 to 60
  std::string units = "bench";   ///< the page's first choice of units: "bench" or "si"
  std::string version;
  std::string_view page;  ///< HTML; "": the program was built without it
};

class Server {
 public:
  /// Opens the port; no request is answered before run(). Throws UserError.
  Server(ServerSettings settings, Source& source);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /// Starts the source, serves until stop(), stops the source.
  void run();
  /// May be called from any thread.
  void stop();

 private:
  class Body;
  std::unique_ptr<Body> body_;
};

}  // namespace smaservo::page
