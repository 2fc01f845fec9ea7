#pragma once
// HTTP by libwebsockets: headers of requests, and answers.

#include <libwebsockets.h>
#include <optional>
#include <string>
#include <string_view>

#include "host-sim/page/access.hpp"

namespace smaservo::page {

/// Number of bytes that are written at once.
inline constexpr std::size_t chunk = 16384;

enum HttpStatus : int {
  ok = 200,
  bad_request = 400,
  not_found = 404,
  not_allowed = 405,
  unavailable = 503
};

/// A header of a request; "" if it is missing, nullopt if it is too long.
std::optional<std::string> header(lws* wsi, lws_token_indexes which);
/// Whether the request may be answered, by its Host, Origin and token.
Verdict judge(const AccessRules& rules, lws* wsi);

/// The Content-Security-Policy of the page: it may load nothing, and connect only to its own
/// server. Its scripts and styles are inline, because it is one file. `host` has passed judge(), so
/// it contains nothing but a host.
std::string content_policy(const std::string& host, bool tls);
/// False if the connection has failed.
bool write_headers(lws* wsi, int status, const char* type, std::size_t length,
                   const std::string& policy);
/// Sends an answer of a few lines. False if the connection has failed.
bool say(lws* wsi, int status, std::string_view text);

/// Throws UserError if it is not possible to listen there; libwebsockets does not give the reason.
void check_address(const Listen& listen);

}  // namespace smaservo::page
