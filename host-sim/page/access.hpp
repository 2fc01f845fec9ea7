#pragma once
// Decides who may connect, by the headers of one request, as a pure function.
//
// A page of any origin can make a browser send requests to this machine. So on a loopback address
// the Host reveals a foreign name that resolves to it (DNS rebinding), and the Origin reveals a
// foreign page. On any other address every client needs the token.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::page {

/// The address and port at which the server listens.
struct Listen {
  std::string address;  ///< IPv4 or IPv6, without brackets
  std::uint16_t port = 0;
  bool loopback = true;

  /// The address as in a URL: 127.0.0.1:8765, [::1]:8765.
  std::string text() const;
};

/// Reads ADDRESS:PORT, [ADDRESS]:PORT or PORT. Throws ConfigError.
Listen parse_listen(std::string_view text);

struct AccessRules {
  Listen listen;
  std::string token;                 ///< "": no token is needed
  std::vector<std::string> origins;  ///< allowed in addition to the server's own
};

/// The headers of a request; "" for a missing header.
struct Request {
  std::string host, origin, authorization;
  std::string token;  ///< from the query of the URL
};

/// `status` is that of HTTP, 200 if the request is allowed; `why` is the reason for a refusal.
struct Verdict {
  int status;
  std::string why;
};

Verdict judge(const AccessRules& rules, const Request& request);

/// Whether two texts are equal, in a time that depends only on the length of the first.
bool equal_in_constant_time(std::string_view given, std::string_view secret);

}  // namespace smaservo::page
