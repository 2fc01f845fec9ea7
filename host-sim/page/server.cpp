#include "host-sim/page/server.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <libwebsockets.h>
#include <map>
#include <mutex>
#include <sys/socket.h>
#include <unistd.h>

#include "host-sim/page/foxglove.hpp"
#include "host-sim/page/mailbox.hpp"
#include "host-sim/page/token_file.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::page {
namespace {

/// Bytes that are written at once.
constexpr std::size_t chunk = 16384;
/// Messages that are written to one client before the others have their turn.
constexpr int burst = 16;
/// Small, so that what a client has not read is in its queue, where the oldest can be dropped, and
/// a ping does not wait behind a second of messages.
constexpr int kernel_buffer = 65536;

/// A ping each second; who has not answered it 3 s later is gone.
constexpr lws_retry_bo_t patience{.retry_ms_table = nullptr,
                                  .retry_ms_table_count = 0,
                                  .conceal_count = 0,
                                  .secs_since_valid_ping = 1,
                                  .secs_since_valid_hangup = 4,
                                  .jitter_percent = 0};

constexpr std::string_view no_page =
    "This host-sim was built without node and npm, so it has no page.\n"
    "Its WebSocket is there all the same: connect Foxglove, Lichtblick or PlotJuggler\n"
    "(Foxglove WebSocket) to this address, with ws in the place of http.\n"
    "For the page: toolchain/dev setup, then build anew.\n";

enum HttpStatus : int {
  ok = 200,
  bad_request = 400,
  not_found = 404,
  not_allowed = 405,
  unavailable = 503
};

/// What libwebsockets has last said, where it fails.
std::string& last_complaint() {
  static std::string text;
  return text;
}

void keep_complaint(int /*level*/, const char* line) {
  const std::string_view text(line);
  last_complaint() = text.substr(0, text.find('\n'));
}

/// A header of a request; "" where it is missing, nothing where it is too long.
std::optional<std::string> header(lws* wsi, lws_token_indexes which) {
  std::array<char, 1024> text{};
  const int length = lws_hdr_total_length(wsi, which);
  if (length <= 0) return "";
  const int copied = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), which);
  if (copied < 0) return std::nullopt;
  return std::string(text.data(), static_cast<std::size_t>(copied));
}

std::string query_token(lws* wsi) {
  constexpr std::string_view key = "token=";
  std::array<char, 512> text{};
  for (int i = 0;; ++i) {
    const int length = lws_hdr_copy_fragment(wsi, text.data(), static_cast<int>(text.size()),
                                             WSI_TOKEN_HTTP_URI_ARGS, i);
    if (length < 0) return "";
    const std::string_view argument(text.data(), static_cast<std::size_t>(length));
    if (argument.starts_with(key)) return std::string(argument.substr(key.size()));
  }
}

Verdict judge(const AccessRules& rules, lws* wsi) {
  const auto host = header(wsi, WSI_TOKEN_HOST);
  const auto origin = header(wsi, WSI_TOKEN_ORIGIN);
  const auto authorization = header(wsi, WSI_TOKEN_HTTP_AUTHORIZATION);
  if (!host || !origin || !authorization) return {400, "a header is too long"};
  return page::judge(rules, {*host, *origin, *authorization, query_token(wsi)});
}

/// Whether one of ours is in the list, which libwebsockets then chooses.
bool names_protocol(std::string_view list) {
  return list.find("foxglove.websocket.v1") != std::string_view::npos ||
         list.find("foxglove.sdk.v1") != std::string_view::npos;
}

/// A page may load nothing, and connect to nothing but where it comes from. Its scripts and styles
/// are in it, for it is one file. `host` has passed judge(), so it is nothing but a host.
std::string content_policy(const std::string& host, bool tls) {
  return fmt::format(
      "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
      "img-src data: blob:; font-src data:; connect-src 'self' {}://{}; base-uri 'none'; "
      "form-action 'none'; frame-ancestors 'none'",
      tls ? "wss" : "ws", host);
}

bool add_header(lws* wsi, const char* name, std::string_view value, unsigned char** at,
                unsigned char* end) {
  // NOLINTNEXTLINE(*-reinterpret-cast): characters as bytes
  const auto bytes = [](const char* text) { return reinterpret_cast<const unsigned char*>(text); };
  return lws_add_http_header_by_name(wsi, bytes(name), bytes(value.data()),
                                     static_cast<int>(value.size()), at, end) == 0;
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

/// An answer of a few lines.
bool say(lws* wsi, int status, std::string_view text) {
  std::vector<unsigned char> buffer(LWS_PRE + text.size());
  std::ranges::copy(text, buffer.begin() + LWS_PRE);
  return write_headers(wsi, status, "text/plain; charset=utf-8", text.size(),
                       "default-src 'none'; frame-ancestors 'none'") &&
         lws_write(wsi, buffer.data() + LWS_PRE, text.size(), LWS_WRITE_HTTP_FINAL) >= 0;
}

/// Whether one could listen there; libwebsockets does not say why it cannot.
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
  // NOLINTBEGIN(*-reinterpret-cast): that is how bind() takes an address
  const int failed = is_v4 ? bind(fd, reinterpret_cast<const sockaddr*>(&v4), sizeof v4)
                           : bind(fd, reinterpret_cast<const sockaddr*>(&v6), sizeof v6);
  // NOLINTEND(*-reinterpret-cast)
  const int error = errno;
  close(fd);
  if (failed == 0) return;
  throw files::UserError(
      fmt::format("--listen {}: {}", listen.text(),
                  error == EADDRINUSE      ? "another program listens there; choose another port"
                  : error == EADDRNOTAVAIL ? "is no address of this machine"
                  : error == EACCES        ? "ports below 1024 are root's; choose another"
                                           : std::strerror(error)));
}

void check_readable(const char* option, const std::string& path) {
  if (access(path.c_str(), R_OK) != 0) {
    throw files::UserError(
        fmt::format("{} {}: {}", option, files::printable(path), std::strerror(errno)));
  }
}

/// How a client stands, for all threads.
struct Shown {
  std::string address;
  std::atomic<std::uint64_t> queued = 0, dropped = 0;
};

}  // namespace

/// All but the constructor, the destructor, stop() and the functions of Sink runs in one thread.
class Server::Body final : public Sink {
 public:
  Body(ServerSettings settings, Source& source);
  ~Body() override;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  std::uint16_t port() const { return settings_.access.listen.port; }
  void run();
  void stop();

  // Sink
  void message(std::uint32_t channel, std::int64_t time_ns,
               std::shared_ptr<const std::string> json) override {
    mailbox_->post({channel, time_ns, std::move(json)});
  }
  void channels_changed() override {
    mailbox_->post([this] { show_channels(); });
  }
  void parameters_changed(const std::vector<NamedValue>& values) override {
    mailbox_->post([this, values] { show_parameters(values); });
  }
  std::vector<ClientState> clients() override;

 private:
  class Client;
  /// What libwebsockets keeps for a connection, as zeros at first.
  struct Session {
    Client* client;
    std::size_t sent;  ///< of the page
  };

  static int on_event(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                      std::size_t length);
  int handle(lws* wsi, lws_callback_reasons reason, Session* session, std::string_view in);
  int serve_http(lws* wsi, std::string_view path);
  int serve_page(lws* wsi, Session& session);
  int may_upgrade(lws* wsi);
  void join(lws* wsi, Session& session);
  void leave(Session& session);
  void deliver();
  void show_channels();
  void show_parameters(const std::vector<NamedValue>& values);
  void count(std::uint32_t channel, int change);
  template <class Deliver>
  auto to_client(std::uint32_t client, Deliver deliver);
  void open_context();
  void open_vhost();

  bool tls() const { return !settings_.certificate.empty(); }

  ServerSettings settings_;
  Source& source_;
  std::vector<Service> services_;
  std::vector<Channel> channels_;
  std::map<std::uint32_t, unsigned> wanted_;  ///< clients that have subscribed each channel
  std::string session_ = random_token().substr(0, 16);
  std::shared_ptr<Mailbox> mailbox_;
  lws_context* context_ = nullptr;
  std::atomic<bool> stopping_ = false;
  bool stopped_ = false;  ///< the source
  std::uint32_t last_client_ = 0;
  std::map<std::uint32_t, std::unique_ptr<Client>> clients_;
  std::mutex shown_mutex_;
  std::map<std::uint32_t, std::shared_ptr<Shown>> shown_;
};

class Server::Body::Client final : public Desk {
 public:
  Client(Body& body, lws* wsi, std::uint32_t id, std::shared_ptr<Shown> shown)
      : body_(body),
        wsi_(wsi),
        id_(id),
        shown_(std::move(shown)),
        conversation_(*this, body.services_) {}

  Conversation& conversation() { return conversation_; }
  std::uint32_t id() const { return id_; }

  // Desk
  void send(Frame frame) override {
    if (!queue_.push(std::move(frame)) && !doomed_) {
      doomed_ = true;
      lws_set_timeout(wsi_, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
    }
    show();
    lws_callback_on_writable(wsi_);
  }
  void subscribe(std::uint32_t channel, bool wanted) override {
    body_.count(channel, wanted ? 1 : -1);
  }
  void get_parameters(std::vector<std::string> names, std::optional<std::string> id) override;
  void set_parameters(std::vector<NamedValue> values, std::optional<std::string> id) override;
  void call(std::uint32_t service, std::uint32_t call, std::string request) override;

  /// Some bytes of a message; what closes the connection is negative.
  int hear(std::string_view bytes);
  /// When there is room for something.
  int write();
  void lost(std::uint64_t messages) {
    queue_.count_dropped(messages);
    show();
  }

 private:
  std::size_t fill(const Frame& frame);
  int write_piece();
  Caller caller() const { return {id_, body_.settings_.read_only}; }
  void show() const {
    shown_->queued = queue_.size();
    shown_->dropped = queue_.dropped();
  }

  Body& body_;
  lws* wsi_;
  std::uint32_t id_;
  std::shared_ptr<Shown> shown_;
  Conversation conversation_;
  SendQueue queue_;
  /// In pieces, so that a long answer to one client takes no time from the others.
  std::optional<Frame> going_out_;
  std::size_t sent_ = 0;  ///< of it
  std::string heard_;
  std::vector<unsigned char> buffer_;
  bool doomed_ = false;
};

// What a client asks, and what becomes of the answer.

/// A function that may be called from any thread, and posts what it is given. Then, in the server's
/// thread, it is delivered if the client is still there.
template <class Deliver>
auto Server::Body::to_client(std::uint32_t client, Deliver deliver) {
  // The mailbox, unlike the server, may be outlived by nothing that calls this.
  return [this, mailbox = mailbox_, client, deliver](auto... what) {
    mailbox->post([this, client, deliver, ... what = std::move(what)]() mutable {
      if (const auto found = clients_.find(client); found != clients_.end()) {
        deliver(found->second->conversation(), std::move(what)...);
      }
    });
  };
}

void Server::Body::Client::get_parameters(std::vector<std::string> names,
                                          std::optional<std::string> id) {
  body_.source_.get_parameters(
      std::move(names),
      body_.to_client(id_, [id](Conversation& to, const std::vector<NamedValue>& values) {
        to.parameter_values(values, id, "");
      }));
}

void Server::Body::Client::set_parameters(std::vector<NamedValue> values,
                                          std::optional<std::string> id) {
  body_.source_.set_parameters(
      caller(), std::move(values),
      body_.to_client(
          id_, [id](Conversation& to, const std::vector<NamedValue>& in_force,
                    const std::string& refusal) { to.parameter_values(in_force, id, refusal); }));
}

void Server::Body::Client::call(std::uint32_t service, std::uint32_t call, std::string request) {
  body_.source_.call(caller(), service, std::move(request),
                     body_.to_client(id_, [service, call](Conversation& to, Answer answer) {
                       to.answer(service, call, std::move(answer));
                     }));
}

int Server::Body::Client::hear(std::string_view bytes) {
  if (lws_is_first_fragment(wsi_) != 0) {
    heard_.clear();
  }
  if (heard_.size() + bytes.size() > limits::message_bytes) {
    std::string why = fmt::format("longer than {} bytes", limits::message_bytes);
    // NOLINTNEXTLINE(*-reinterpret-cast): characters as bytes
    lws_close_reason(wsi_, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE,
                     reinterpret_cast<unsigned char*>(why.data()), why.size());
    return -1;
  }
  heard_ += bytes;
  if (lws_is_final_fragment(wsi_) != 0) {
    if (lws_frame_is_binary(wsi_) != 0) {
      conversation_.hear_bytes(heard_);
    } else {
      conversation_.hear_text(heard_);
    }
    heard_.clear();
  }
  return 0;
}

/// The next piece of the message that goes out.
std::size_t Server::Body::Client::fill(const Frame& frame) {
  const std::size_t length = std::min(chunk, frame.size() - sent_);
  buffer_.resize(LWS_PRE + length);
  const auto from_head =
      std::string_view(frame.head).substr(std::min(sent_, frame.head.size()), length);
  auto at = std::ranges::copy(from_head, buffer_.begin() + LWS_PRE).out;
  if (from_head.size() < length) {
    const std::size_t start = sent_ + from_head.size() - frame.head.size();
    std::ranges::copy(std::string_view(*frame.body).substr(start, length - from_head.size()), at);
  }
  return length;
}

/// Negative: the connection has failed.
int Server::Body::Client::write_piece() {
  const std::size_t length = fill(*going_out_);
  const bool last = sent_ + length == going_out_->size();
  const int flags = lws_write_ws_flags(going_out_->binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT,
                                       static_cast<int>(sent_ == 0), static_cast<int>(last));
  sent_ += length;
  if (last) going_out_.reset();
  return lws_write(wsi_, buffer_.data() + LWS_PRE, length, static_cast<lws_write_protocol>(flags));
}

int Server::Body::Client::write() {
  if (doomed_) return -1;
  // Several small ones at once, for who has not run for a while; never more than the socket takes.
  for (int i = 0; i < burst && lws_partial_buffered(wsi_) == 0; ++i) {
    if (!going_out_) {
      going_out_ = queue_.pop();
      sent_ = 0;
    }
    if (!going_out_) break;
    const bool small = going_out_->size() < chunk;
    if (write_piece() < 0) return -1;
    if (!small) break;
  }
  show();
  if (going_out_ || !queue_.empty()) lws_callback_on_writable(wsi_);
  return 0;
}

// Connections.

std::vector<ClientState> Server::Body::clients() {
  const std::scoped_lock lock(shown_mutex_);
  std::vector<ClientState> all;
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
  clients_.emplace(id, std::move(client));
  {
    const std::scoped_lock lock(shown_mutex_);
    shown_.emplace(id, std::move(shown));
  }
  session.client->conversation().greet({.version = settings_.version,
                                        .session = session_,
                                        .client = id,
                                        .read_only = settings_.read_only},
                                       channels_);
}

void Server::Body::leave(Session& session) {
  if (session.client == nullptr) return;
  const std::uint32_t id = session.client->id();
  const std::vector<std::uint32_t> channels = session.client->conversation().subscribed_channels();
  session.client = nullptr;
  clients_.erase(id);
  {
    const std::scoped_lock lock(shown_mutex_);
    shown_.erase(id);
  }
  if (stopped_) return;
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
      client->conversation().message(live.channel, live.time_ns, live.json);
    }
    if (mail.lost > 0) client->lost(mail.lost);
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

/// Nonzero: the request was refused. Negative: so was the connection.
int Server::Body::may_upgrade(lws* wsi) {
  const std::string path = header(wsi, WSI_TOKEN_GET_URI).value_or("");
  Verdict verdict = judge(settings_.access, wsi);
  // Foxglove's own default is an address without a path.
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
  if (verdict.status == ok) return 0;
  return say(wsi, verdict.status, verdict.why + "\n") ? 1 : -1;
}

int Server::Body::serve_http(lws* wsi, std::string_view path) {
  // What is no page ends the connection, with whatever else the client wants to send on it.
  const auto only = [&](int status, std::string_view text) {
    say(wsi, status, text);
    return -1;
  };
  const Verdict verdict = judge(settings_.access, wsi);
  if (verdict.status != ok) return only(verdict.status, verdict.why + "\n");
  if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) return only(not_allowed, "only GET\n");
  if (path != "/") return only(not_found, "there is / and the WebSocket /ws\n");
  if (settings_.page.empty()) return only(ok, no_page);
  if (!write_headers(wsi, ok, "text/html; charset=utf-8", settings_.page.size(),
                     content_policy(header(wsi, WSI_TOKEN_HOST).value_or(""), tls()))) {
    return -1;
  }
  lws_callback_on_writable(wsi);
  return 0;
}

int Server::Body::serve_page(lws* wsi, Session& session) {
  const std::string_view rest = settings_.page.substr(session.sent);
  if (rest.empty()) return 0;
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
    case LWS_CALLBACK_RECEIVE:
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

/// libwebsockets calls this, and knows no exceptions.
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

// Life.

void Server::Body::open_context() {
  lws_set_log_level(LLL_ERR, keep_complaint);
  lws_context_creation_info info{};
  info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS | LWS_SERVER_OPTION_VALIDATE_UTF8 |
                 LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME;
  if (tls()) info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
  info.user = this;
  info.fd_limit_per_thread = settings_.clients + 64;
  context_ = lws_create_context(&info);
  if (context_ == nullptr) {
    throw files::UserError(fmt::format("libwebsockets does not start: {}", last_complaint()));
  }
}

void Server::Body::open_vhost() {
  // Foxglove's newer clients know the same protocol by its second name. A client that names none
  // gets the first, which speaks HTTP only.
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
  info.retry_and_idle_policy = &patience;
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
  // From now on it would tell of every connection that somebody else has ended.
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
