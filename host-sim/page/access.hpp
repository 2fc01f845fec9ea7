#pragma once
// Who may connect: rules on one request's headers, as a pure function.
//
// A page of any origin can make a browser send requests to this machine, so on a loopback address
// it is the Host that tells a foreign name which resolves to it (DNS rebinding), and the Origin
// that tells a foreign page. On any other address whoever connects needs the token.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::page {

/// Where the server listens.
struct Listen {
  std::string address;  ///< IPv4 or IPv6, without brackets
  std::uint16_t port = 0;
  bool loopback = true;

  /// As it stands in a URL: 127.0.0.1:8765, [::1]:8765.
  std::string text() const;
};

/// Reads ADDRESS:PORT, [ADDRESS]:PORT or PORT. Throws ConfigError.
Listen parse_listen(std::string_view text);

struct AccessRules {
  Listen listen;
  std::string token;                 ///< "": none is asked for
  std::vector<std::string> origins;  ///< allowed beside the server's own
};

/// What a request says of itself; "" is a header that is not there.
struct Request {
  std::string host, origin, authorization;
  std::string token;  ///< of the query
};

/// `status` is HTTP's, 200 where the request may go on; `why` says why not.
struct Verdict {
  int status;
  std::string why;
};

Verdict judge(const AccessRules& rules, const Request& request);

/// Whether two texts are equal, in a time that depends on the length of the first only.
bool equal_in_constant_time(std::string_view given, std::string_view secret);

}  // namespace smaservo::page
