#include "host-sim/page/server/server.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include "host-sim/page/server/body.hpp"
#include "host-sim/page/server/http.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

/// Small, so that messages that a client has not read stay in its queue, where the oldest can be
/// dropped, and a ping does not wait behind a second of messages.
constexpr int kernel_buffer = 65536;

constexpr std::string_view no_page =
    "This host-sim was built without node and npm, so it has no page.\n"
    "Its WebSocket is there all the same: connect Foxglove, Lichtblick or PlotJuggler\n"
    "(Foxglove WebSocket) to this address, with ws in the place of http.\n"
    "For the page: toolchain/dev setup, then build anew.\n";

/// The last error message of libwebsockets.
std::string& last_complaint() {
  static std::string text;
  return text;
}

void keep_complaint(int /*level*/, const char* line) {
  const std::string_view text(line);
  last_complaint() = text.substr(0, text.find('\n'));
}

/// Whether the list contains one of our protocols, which libwebsockets then chooses.
bool names_protocol(std::string_view list) {
  return list.find("foxglove.websocket.v1") != std::string_view::npos ||
         list.find("foxglove.sdk.v1") != std::string_view::npos;
}

void check_readable(const char* option, const std::string& path) {
  if (access(path.c_str(), R_OK) != 0) {
    throw files::UserError(
        fmt::format("{} {}: {}", option, files::printable(path), std::strerror(errno)));
  }
}

}  // namespace

// Connections.

std::vector<ClientState> Server::Body::clients() {
  const std::scoped_lock lock(shown_mutex_);
  std::vector<ClientState> all;
  all.reserve(shown_.size());
  for (const auto& [id, shown] : shown_) {
    all.push_back({id, shown->address, shown->queued, shown->dropped, settings_.read_only});
  }
  return all;
}

void Server::Body::join(lws* wsi, Session& session) {
  setsockopt(lws_get_socket_fd(wsi), SOL_SOCKET, SO_SNDBUF, &kernel_buffer, sizeof kernel_buffer);
  std::array<char, 64> address{};
  lws_get_peer_simple(wsi, address.data(), address.size());
  auto shown = std::make_shared<Shown>();
  shown->address = address.data();
  const std::uint32_t id = ++last_client_;
  auto client = std::make_unique<Client>(*this, wsi, id, shown);
  session.client = client.get();
  session.heard_us = lws_now_usecs();
  clients_.emplace(id, std::move(client));
  {
    const std::scoped_lock lock(shown_mutex_);
    shown_.emplace(id, std::move(shown));
  }
  session.client->conversation().greet({.version = settings_.version,
                                        .session = session_,
                                        .client = id,
                                        .read_only = settings_.read_only,
                                        .units = settings_.units},
                                       channels_);
}

void Server::Body::leave(Session& session) {
  if (session.client == nullptr) {
    return;
  }
  const std::uint32_t id = session.client->id();
  const std::int64_t silent_us = lws_now_usecs() - session.heard_us;
  if (!stopped_ && silent_us >= 1'000'000LL * (settings_.patience_s - 1)) {
    files::complain("host-sim",
                    fmt::format("page: client {} closed: silent for {:.1f} s (--patience {})", id,
                                static_cast<double>(silent_us) * 1e-6, settings_.patience_s));
  }
  const std::vector<std::uint32_t> channels = session.client->conversation().subscribed_channels();
  session.client = nullptr;
  clients_.erase(id);
  {
    const std::scoped_lock lock(shown_mutex_);
    shown_.erase(id);
  }
  if (stopped_) {
    return;
  }
  source_.client_left(id);
  for (const std::uint32_t channel : channels) {
    count(channel, -1);
  }
}

void Server::Body::count(std::uint32_t channel, int change) {
  unsigned& clients = wanted_[channel];
  clients = change > 0 ? clients + 1 : clients - 1;
  source_.subscribed(channel, clients);
}

void Server::Body::deliver() {
  const Mailbox::Mail mail = mailbox_->take();
  for (const Mailbox::Errand& errand : mail.errands) {
    errand();
  }
  for (const auto& [id, client] : clients_) {
    for (const Mailbox::Live& live : mail.live) {
      client->conversation().message(live.channel, live.time_ns, live.bytes);
    }
    if (mail.lost > 0) {
      client->lost(mail.lost);
    }
  }
}

void Server::Body::show_channels() {
  channels_ = source_.channels();
  wanted_.clear();
  for (const auto& [id, client] : clients_) {
    client->conversation().show_channels(channels_);
    for (const std::uint32_t channel : client->conversation().subscribed_channels()) {
      ++wanted_[channel];
    }
  }
}

void Server::Body::show_parameters(const std::vector<NamedValue>& values) {
  for (const auto& [id, client] : clients_) {
    client->conversation().parameters_changed(values);
  }
}

// HTTP.

/// Nonzero if the request was refused; negative if the connection is to be closed as well.
int Server::Body::may_upgrade(lws* wsi) {
  const std::string path = header(wsi, WSI_TOKEN_GET_URI).value_or("");
  Verdict verdict = judge(settings_.access, wsi);
  // Foxglove's default is an address without a path.
  if (verdict.status == ok && path != "/ws" && path != "/") {
    verdict = {not_found, "the WebSocket is /ws"};
  }
  if (verdict.status == ok && !names_protocol(header(wsi, WSI_TOKEN_PROTOCOL).value_or(""))) {
    verdict = {bad_request, "Sec-WebSocket-Protocol must name foxglove.websocket.v1"};
  }
  if (verdict.status == ok && clients_.size() >= settings_.clients) {
    verdict = {unavailable,
               fmt::format("{} clients are connected; --clients allows more", clients_.size())};
  }
  if (verdict.status == ok) {
    return 0;
  }
  return say(wsi, verdict.status, verdict.why + "\n") ? 1 : -1;
}

int Server::Body::serve_http(lws* wsi, std::string_view path) {
  // An answer other than the page ends the connection, and anything else that the client would send
  // on it.
  const auto only = [&](int status, std::string_view text) {
    say(wsi, status, text);
    return -1;
  };
  const Verdict verdict = judge(settings_.access, wsi);
  if (verdict.status != ok) {
    return only(verdict.status, verdict.why + "\n");
  }
  if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) {
    return only(not_allowed, "only GET\n");
  }
  if (path != "/") {
    return only(not_found, "there is / and the WebSocket /ws\n");
  }
  if (settings_.page.empty()) {
    return only(ok, no_page);
  }
  if (!write_headers(wsi, ok, "text/html; charset=utf-8", settings_.page.size(),
                     content_policy(header(wsi, WSI_TOKEN_HOST).value_or(""), tls()))) {
    return -1;
  }
  lws_callback_on_writable(wsi);
  return 0;
}

int Server::Body::serve_page(lws* wsi, Session& session) const {
  const std::string_view rest = settings_.page.substr(session.sent);
  if (rest.empty()) {
    return 0;
  }
  const std::string_view part = rest.substr(0, chunk);
  std::vector<unsigned char> buffer(LWS_PRE + part.size());
  std::ranges::copy(part, buffer.begin() + LWS_PRE);
  const bool last = part.size() == rest.size();
  if (lws_write(wsi, buffer.data() + LWS_PRE, part.size(),
                last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0) {
    return -1;
  }
  session.sent += part.size();
  if (!last) {
    lws_callback_on_writable(wsi);
    return 0;
  }
  session.sent = 0;
  return lws_http_transaction_completed(wsi) == 0 ? 0 : -1;
}

int Server::Body::handle(lws* wsi, lws_callback_reasons reason, Session* session,
                         std::string_view in) {
  switch (reason) {
    case LWS_CALLBACK_HTTP:
      return serve_http(wsi, in);
    case LWS_CALLBACK_HTTP_WRITEABLE:
      return serve_page(wsi, *session);
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
      return may_upgrade(wsi);
    case LWS_CALLBACK_ESTABLISHED:
      join(wsi, *session);
      return 0;
    case LWS_CALLBACK_RECEIVE_PONG:
      session->heard_us = lws_now_usecs();
      return 0;
    case LWS_CALLBACK_RECEIVE:
      session->heard_us = lws_now_usecs();
      return session->client == nullptr ? -1 : session->client->hear(in);
    case LWS_CALLBACK_SERVER_WRITEABLE:
      return session->client == nullptr ? -1 : session->client->write();
    case LWS_CALLBACK_CLOSED:
      leave(*session);
      return 0;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
      deliver();
      return 0;
    default:
      return 0;
  }
}

/// Called by libwebsockets, which does not handle exceptions.
int Server::Body::on_event(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                           std::size_t length) {
  auto* body = static_cast<Body*>(lws_context_user(lws_get_context(wsi)));
  const std::string_view text =
      in == nullptr ? std::string_view{} : std::string_view(static_cast<const char*>(in), length);
  try {
    return body->handle(wsi, reason, static_cast<Session*>(user), text);
  } catch (const std::exception& error) {
    files::complain("host-sim", fmt::format("page: {}", error.what()));
    return -1;
  }
}

// Starting and running.

void Server::Body::open_context() {
  lws_set_log_level(LLL_ERR, keep_complaint);
  lws_context_creation_info info{};
  info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_VALIDATE_UTF8 |
                 LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME;
  if (tls()) {
    info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
  }
  info.user = this;
  info.fd_limit_per_thread = settings_.clients + 64;
  context_ = lws_create_context(&info);
  if (context_ == nullptr) {
    throw files::UserError(fmt::format("libwebsockets does not start: {}", last_complaint()));
  }
}

void Server::Body::open_vhost() {
  // Foxglove's newer clients use the same protocol under its second name. A client that names no
  // protocol gets the first one, which is HTTP only.
  static const std::array<lws_protocols, 4> protocols{
      {{"http", on_event, sizeof(Session), 0, 0, nullptr, 0},
       {"foxglove.websocket.v1", on_event, sizeof(Session), chunk, 1, nullptr, 0},
       {"foxglove.sdk.v1", on_event, sizeof(Session), chunk, 2, nullptr, 0},
       {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};
  const Listen& listen = settings_.access.listen;
  lws_context_creation_info info{};
  info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8;
  if (listen.address.find(':') == std::string::npos) {
    info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
  }
  if (tls()) {
    info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
    info.ssl_cert_filepath = settings_.certificate.c_str();
    info.ssl_private_key_filepath = settings_.key.c_str();
    info.alpn = "http/1.1";
  }
  info.port = listen.port;
  info.iface = listen.address.c_str();
  info.protocols = protocols.data();
  // A ping is sent each second.
  patience_.secs_since_valid_ping = 1;
  patience_.secs_since_valid_hangup = static_cast<std::uint16_t>(settings_.patience_s);
  info.retry_and_idle_policy = &patience_;
  info.server_string = "smaservo";
  info.timeout_secs = 5;
  info.keepalive_timeout = 5;
  lws_vhost* vhost = lws_create_vhost(context_, &info);
  if (vhost == nullptr) {
    throw files::UserError(fmt::format("--listen {}{}: {}", listen.text(),
                                       tls() ? ", --certificate, --key" : "",
                                       files::printable(last_complaint())));
  }
  settings_.access.listen.port = static_cast<std::uint16_t>(lws_get_vhost_listen_port(vhost));
}

Server::Body::Body(ServerSettings settings, Source& source)
    : settings_(std::move(settings)), source_(source) {
  if (tls()) {
    check_readable("--certificate", settings_.certificate);
    check_readable("--key", settings_.key);
  }
  check_address(settings_.access.listen);
  open_context();
  mailbox_ = std::make_shared<Mailbox>([context = context_] { lws_cancel_service(context); });
  try {
    open_vhost();
  } catch (...) {
    lws_context_destroy(context_);
    throw;
  }
  // From now on libwebsockets would report every connection that the other side has closed.
  lws_set_log_level(0, nullptr);
}

Server::Body::~Body() {
  mailbox_->close();
  lws_context_destroy(context_);
}

void Server::Body::run() {
  services_ = source_.services();
  channels_ = source_.channels();
  source_.start(*this);
  while (!stopping_ && lws_service(context_, 0) >= 0) {
  }
  stopped_ = true;
  source_.stop();
}

void Server::Body::stop() {
  stopping_ = true;
  lws_cancel_service(context_);
}

Server::Server(ServerSettings settings, Source& source)
    : body_(std::make_unique<Body>(std::move(settings), source)) {}
Server::~Server() = default;
std::uint16_t Server::port() const {
  return body_->port();
}
void Server::run() {
  body_->run();
}
void Server::stop() {
  body_->stop();
}

}  // namespace smaservo::page
