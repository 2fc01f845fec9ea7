#pragma once
// HTTP by libwebsockets: headers of requests, and answers.

#include <libwebsockets.h>
#include <optional>
#include <string>
#include <string_view>

#include "host-sim/page/access.hpp"

namespace smaservo::page {

/// Bytes that are written at once.
inline constexpr std::size_t chunk = 16384;

enum HttpStatus : int {
  ok = 200,
  bad_request = 400,
  not_found = 404,
  not_allowed = 405,
  unavailable = 503
};

/// A header of a request; "" where it is missing, nothing where it is too long.
std::optional<std::string> header(lws* wsi, lws_token_indexes which);
/// Whether the request may be answered, by its Host, Origin and token.
Verdict judge(const AccessRules& rules, lws* wsi);

/// A page may load nothing, and connect to nothing but where it comes from. Its scripts and styles
/// are in it, for it is one file. `host` has passed judge(), so it is nothing but a host.
std::string content_policy(const std::string& host, bool tls);
/// False: the connection has failed.
bool write_headers(lws* wsi, int status, const char* type, std::size_t length,
                   const std::string& policy);
/// An answer of a few lines. False: the connection has failed.
bool say(lws* wsi, int status, std::string_view text);

/// Throws UserError where one could not listen there; libwebsockets does not say why it cannot.
void check_address(const Listen& listen);

}  // namespace smaservo::page
