#include "host-sim/page/access.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>

#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

std::string lower(std::string_view text) {
  std::string all(text);
  std::ranges::transform(all, all.begin(), [](char c) {
    return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  return all;
}

/// Whether the text has only the characters of a host with a port: no others may stand in a header
/// or in a Content-Security-Policy.
bool is_host(std::string_view text) {
  return !text.empty() && text.size() < 256 &&
         std::ranges::all_of(
             text,
             [](char c) {
               return ('0' <= c && c <= '9') || ('a' <= c && c <= 'z') || c == '.' || c == '-' ||
                      c == ':' || c == '[' || c == ']';
             });
}

/// The name without the port: "[::1]" for "[::1]:8765".
std::string_view name_of(std::string_view host) {
  const std::size_t bracket = host.find(']');
  const std::size_t colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  return host.substr(0, colon);
}

bool is_loopback_name(std::string_view name, const Listen& listen) {
  return name == "localhost" || name == "127.0.0.1" || name == "[::1]" ||
         name == name_of(listen.text());
}

std::string_view without_scheme(std::string_view origin) {
  const std::size_t end = origin.find("://");
  return end == std::string_view::npos ? std::string_view{} : origin.substr(end + 3);
}

std::string_view bearer(std::string_view authorization) {
  constexpr std::string_view scheme = "bearer ";
  return lower(authorization.substr(0, scheme.size())) == scheme
             ? authorization.substr(scheme.size())
             : std::string_view{};
}

/// 4 or 6 for an address of IPv4 or IPv6; 0 if the text is no address.
int family(const std::string& address) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  if (inet_pton(AF_INET, address.c_str(), bytes.data()) == 1) {
    return 4;
  }
  return inet_pton(AF_INET6, address.c_str(), bytes.data()) == 1 ? 6 : 0;
}

[[noreturn]] void refuse_listen(std::string_view text) {
  throw files::ConfigError(fmt::format(
      "--listen {}: must be ADDRESS:PORT with an IP address and a port of 0 to 65535, such as "
      "127.0.0.1:8765, [::1]:8765 or, from elsewhere with a token, 0.0.0.0:8765",
      files::printable(text)));
}

}  // namespace

std::string Listen::text() const {
  return address.find(':') == std::string::npos ? fmt::format("{}:{}", address, port)
                                                : fmt::format("[{}]:{}", address, port);
}

Listen parse_listen(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  const std::string_view port = colon == std::string_view::npos ? text : text.substr(colon + 1);
  std::string_view address =
      colon == std::string_view::npos ? std::string_view("127.0.0.1") : text.substr(0, colon);
  const bool bracketed = address.starts_with('[') && address.ends_with(']');
  if (bracketed) {
    address = address.substr(1, address.size() - 2);
  }
  Listen listen{.address = address == "localhost" ? "127.0.0.1" : std::string(address)};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), listen.port);
  const int is = family(listen.address);
  if (error != std::errc{} || end != port.data() + port.size() || is == 0 ||
      bracketed != (is == 6)) {
    refuse_listen(text);
  }
  listen.loopback = is == 4 ? listen.address.starts_with("127.") : listen.address == "::1";
  return listen;
}

Verdict judge(const AccessRules& rules, const Request& request) {
  const std::string host = lower(request.host);
  if (!is_host(host)) {
    return {400, "the request has no Host that could be one"};
  }
  const std::string_view name = name_of(host);
  // If there is a token, a foreign host name is harmless, because no browser adds the token by
  // itself.
  if (rules.token.empty() && !is_loopback_name(name, rules.listen)) {
    return {403, "this Host is not the server's: open it by the address that it has printed"};
  }
  const std::string origin = lower(request.origin);
  const auto is_allowed = [&](const std::string& one) { return lower(one) == origin; };
  if (!origin.empty() && without_scheme(origin) != host &&
      std::ranges::none_of(rules.origins, is_allowed)) {
    return {403, "pages of this Origin may not connect: --allow-origin allows one"};
  }
  if (!rules.token.empty() && !equal_in_constant_time(request.token, rules.token) &&
      !equal_in_constant_time(bearer(request.authorization), rules.token)) {
    return {401, "the token is missing or wrong: open the address that the server has printed"};
  }
  return {200, ""};
}

bool equal_in_constant_time(std::string_view given, std::string_view secret) {
  if (given.size() != secret.size()) {
    return false;
  }
  volatile unsigned char differing = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    differing =
        static_cast<unsigned char>(differing | static_cast<unsigned char>(given[i] ^ secret[i]));
  }
  return differing == 0;
}

}  // namespace smaservo::page
