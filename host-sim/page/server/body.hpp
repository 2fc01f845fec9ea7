#pragma once
// The parts of a Server: its connections, and a client for each WebSocket.

#include <atomic>
#include <libwebsockets.h>
#include <map>
#include <mutex>

#include "host-sim/page/protocol/foxglove.hpp"
#include "host-sim/page/server/mailbox.hpp"
#include "host-sim/page/server/server.hpp"
#include "host-sim/page/token_file.hpp"

namespace smaservo::page {

/// The state of a client's queue, which all threads may read.
struct Shown {
  std::string address;
  std::atomic<std::uint64_t> queued = 0, dropped = 0;
};

/// All functions run in one thread, except the constructor, the destructor, stop() and the
/// functions of Sink.
class Server::Body final : public Sink {
 public:
  Body(ServerSettings settings, Source& source);
  ~Body() override;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  std::uint16_t port() const { return settings_.access.listen.port; }
  void run();
  void stop();

  // The members of Sink.
  void message(std::uint32_t channel, std::int64_t time_ns,
               std::shared_ptr<const std::string> bytes) override {
    mailbox_->post({channel, time_ns, std::move(bytes)});
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
  /// The data that libwebsockets keeps for a connection; zeros at first.
  struct Session {
    Client* client;
    std::size_t sent;       ///< bytes of the page
    std::int64_t heard_us;  ///< time of the client's last message, on the clock of libwebsockets
  };

  static int on_event(lws* wsi, lws_callback_reasons reason, void* user, void* in,
                      std::size_t length);
  int handle(lws* wsi, lws_callback_reasons reason, Session* session, std::string_view in);
  int serve_http(lws* wsi, std::string_view path);
  int serve_page(lws* wsi, Session& session) const;
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
  /// Number of clients that have subscribed to each channel.
  std::map<std::uint32_t, unsigned> wanted_;
  std::string session_ = random_token().substr(0, 16);
  std::shared_ptr<Mailbox> mailbox_;
  lws_context* context_ = nullptr;
  lws_retry_bo_t patience_{};  ///< times after which a silent client gets a ping, and is closed
  std::atomic<bool> stopping_ = false;
  bool stopped_ = false;  ///< the source has been stopped
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

  // The members of Desk.
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

  /// Takes some bytes of a message; a negative result closes the connection.
  int hear(std::string_view bytes);
  /// Called when the socket has room for more.
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
  /// The frame that is being written in pieces, so that a long answer to one client does not delay
  /// the others.
  std::optional<Frame> going_out_;
  std::size_t sent_ = 0;  ///< bytes of going_out_ that have been written
  std::string heard_;
  std::vector<unsigned char> buffer_;
  bool doomed_ = false;
};

/// Returns a function that may be called from any thread and posts its arguments to the server's
/// thread. There they are delivered if the client still exists.
template <class Deliver>
auto Server::Body::to_client(std::uint32_t client, Deliver deliver) {
  // The function shares the mailbox, because it may be called after the server has been destroyed.
  return [this, mailbox = mailbox_, client, deliver](auto... what) {
    mailbox->post([this, client, deliver, ... what = std::move(what)]() mutable {
      if (const auto found = clients_.find(client); found != clients_.end()) {
        deliver(found->second->conversation(), std::move(what)...);
      }
    });
  };
}

}  // namespace smaservo::page
