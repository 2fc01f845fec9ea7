#pragma once
// One client's side of the Foxglove WebSocket protocol (foxglove.websocket.v1), without a socket:
// texts and bytes come in, frames go out. Nothing that comes in makes it throw; what is malformed
// is answered by a status message and changes nothing. foxglove.sdk.v1 is the same under another
// name.
//
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "host-sim/page/protocol/limits.hpp"
#include "host-sim/page/protocol/send_queue.hpp"
#include "host-sim/page/source.hpp"

namespace smaservo::page {

/// What a conversation asks of whoever holds it. Answers may come at once or later.
class Desk {
 public:
  virtual ~Desk() = default;
  virtual void send(Frame frame) = 0;
  /// A channel is wanted by this client, or no longer.
  virtual void subscribe(std::uint32_t channel, bool wanted) = 0;
  /// Each is answered by one parameter_values() with this id.
  virtual void get_parameters(std::vector<std::string> names, std::optional<std::string> id) = 0;
  virtual void set_parameters(std::vector<NamedValue> values, std::optional<std::string> id) = 0;
  /// Answered by one answer() with these numbers.
  virtual void call(std::uint32_t service, std::uint32_t call, std::string request) = 0;
};

/// What the server says of itself.
struct ServerInfo {
  std::string version;
  std::string session;  ///< another one for each run of the server
  std::uint32_t client;
  bool read_only;
};

class Conversation {
 public:
  /// `services` must live as long as this. Nothing is sent before greet().
  Conversation(Desk& desk, const std::vector<Service>& services)
      : desk_(desk), services_(services) {}

  /// Server, channels and services. The first that a client hears.
  void greet(const ServerInfo& info, const std::vector<Channel>& channels);

  void hear_text(std::string_view text);
  void hear_bytes(std::string_view bytes);

  /// All channels that there are now; says which have come or gone. What a client had subscribed of
  /// the latter has ended without a word to the desk.
  void show_channels(const std::vector<Channel>& channels);
  void message(std::uint32_t channel, std::int64_t time_ns,
               const std::shared_ptr<const std::string>& bytes);
  /// The answer to a request for parameters; `refusal` says why nothing was written.
  void parameter_values(std::span<const NamedValue> values, const std::optional<std::string>& id,
                        std::string_view refusal);
  /// Values that have changed; those go out that the client has subscribed.
  void parameters_changed(std::span<const NamedValue> values);
  void answer(std::uint32_t service, std::uint32_t call, Answer answer);

  enum class Level { info, warning, error };
  void status(Level level, std::string_view message);

  std::vector<std::uint32_t> subscribed_channels() const;

 private:
  struct Reading;  ///< of one text

  bool may_ask(const char* what);
  void drop_channels(const std::map<std::uint32_t, Channel>& now);
  void send_parameters(std::span<const NamedValue> values, const std::optional<std::string>& id);

  Desk& desk_;
  const std::vector<Service>& services_;
  std::map<std::uint32_t, Channel> channels_;
  std::map<std::uint32_t, std::uint32_t> by_channel_;       ///< subscription of each channel
  std::map<std::uint32_t, std::uint32_t> by_subscription_;  ///< channel of each subscription
  std::set<std::string, std::less<>> named_;  ///< parameters that are wanted; or not, of all
  bool wants_all_ = false;                    ///< parameters, but those that are named
  std::size_t open_ = 0;                      ///< requests that are not answered yet
};

}  // namespace smaservo::page
