#include "host-sim/page/server/http.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

#include "model/files/error.hpp"

namespace smaservo::page {
namespace {

std::string query_token(lws* wsi) {
  constexpr std::string_view key = "token=";
  std::array<char, 512> text{};
  for (int i = 0;; ++i) {
    const int length = lws_hdr_copy_fragment(wsi, text.data(), static_cast<int>(text.size()),
                                             WSI_TOKEN_HTTP_URI_ARGS, i);
    if (length < 0) {
      return "";
    }
    const std::string_view argument(text.data(), static_cast<std::size_t>(length));
    if (argument.starts_with(key)) {
      return std::string(argument.substr(key.size()));
    }
  }
}

bool add_header(lws* wsi, const char* name, std::string_view value, unsigned char** at,
                unsigned char* end) {
  // NOLINTNEXTLINE(*-reinterpret-cast): characters as bytes
  const auto bytes = [](const char* text) { return reinterpret_cast<const unsigned char*>(text); };
  return lws_add_http_header_by_name(wsi, bytes(name), bytes(value.data()),
                                     static_cast<int>(value.size()), at, end) == 0;
}

}  // namespace

std::optional<std::string> header(lws* wsi, lws_token_indexes which) {
  std::array<char, 1024> text{};
  const int length = lws_hdr_total_length(wsi, which);
  if (length <= 0) {
    return "";
  }
  const int copied = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), which);
  if (copied < 0) {
    return std::nullopt;
  }
  return std::string(text.data(), static_cast<std::size_t>(copied));
}

Verdict judge(const AccessRules& rules, lws* wsi) {
  const auto host = header(wsi, WSI_TOKEN_HOST);
  const auto origin = header(wsi, WSI_TOKEN_ORIGIN);
  const auto authorization = header(wsi, WSI_TOKEN_HTTP_AUTHORIZATION);
  if (!host || !origin || !authorization) {
    return {400, "a header is too long"};
  }
  return page::judge(rules, {*host, *origin, *authorization, query_token(wsi)});
}

std::string content_policy(const std::string& host, bool tls) {
  return fmt::format(
      "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
      "img-src data: blob:; font-src data:; connect-src 'self' {}://{}; base-uri 'none'; "
      "form-action 'none'; frame-ancestors 'none'",
      tls ? "wss" : "ws", host);
}

bool write_headers(lws* wsi, int status, const char* type, std::size_t length,
                   const std::string& policy) {
  std::array<unsigned char, LWS_PRE + 2048> buffer{};
  unsigned char* const start = buffer.data() + LWS_PRE;
  unsigned char* at = start;
  unsigned char* const end = buffer.data() + buffer.size() - 1;
  const bool fits = lws_add_http_common_headers(wsi, static_cast<unsigned>(status), type, length,
                                                &at, end) == 0 &&
                    add_header(wsi, "content-security-policy:", policy, &at, end) &&
                    add_header(wsi, "x-content-type-options:", "nosniff", &at, end) &&
                    add_header(wsi, "x-frame-options:", "DENY", &at, end) &&
                    add_header(wsi, "referrer-policy:", "no-referrer", &at, end) &&
                    add_header(wsi, "cross-origin-resource-policy:", "same-origin", &at, end) &&
                    add_header(wsi, "cache-control:", "no-store", &at, end);
  return fits && lws_finalize_write_http_header(wsi, start, &at, end) == 0;
}

bool say(lws* wsi, int status, std::string_view text) {
  std::vector<unsigned char> buffer(LWS_PRE + text.size());
  std::ranges::copy(text, buffer.begin() + LWS_PRE);
  return write_headers(wsi, status, "text/plain; charset=utf-8", text.size(),
                       "default-src 'none'; frame-ancestors 'none'") &&
         lws_write(wsi, buffer.data() + LWS_PRE, text.size(), LWS_WRITE_HTTP_FINAL) >= 0;
}

void check_address(const Listen& listen) {
  sockaddr_in v4{
      .sin_family = AF_INET, .sin_port = htons(listen.port), .sin_addr = {}, .sin_zero = {}};
  sockaddr_in6 v6{.sin6_family = AF_INET6,
                  .sin6_port = htons(listen.port),
                  .sin6_flowinfo = 0,
                  .sin6_addr = {},
                  .sin6_scope_id = 0};
  const bool is_v4 = inet_pton(AF_INET, listen.address.c_str(), &v4.sin_addr) == 1;
  inet_pton(AF_INET6, listen.address.c_str(), &v6.sin6_addr);
  const int fd = socket(is_v4 ? AF_INET : AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  // NOLINTBEGIN(*-reinterpret-cast): bind() takes an address as this type
  const int failed = is_v4 ? bind(fd, reinterpret_cast<const sockaddr*>(&v4), sizeof v4)
                           : bind(fd, reinterpret_cast<const sockaddr*>(&v6), sizeof v6);
  // NOLINTEND(*-reinterpret-cast)
  const int error = errno;
  close(fd);
  if (failed == 0) {
    return;
  }
  throw files::UserError(
      fmt::format("--listen {}: {}", listen.text(),
                  error == EADDRINUSE      ? "another program listens there; choose another port"
                  : error == EADDRNOTAVAIL ? "is no address of this machine"
                  : error == EACCES        ? "ports below 1024 are root's; choose another"
                                           : std::strerror(error)));
}

}  // namespace smaservo::page
