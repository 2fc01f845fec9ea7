#pragma once
// One client's side of the Foxglove WebSocket protocol (foxglove.websocket.v1), without a socket:
// texts and bytes come in, frames go out. No input makes it throw; malformed input is answered by a
// status message and changes nothing. foxglove.sdk.v1 is the same protocol under another name.
//
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>

#include "host-sim/page/protocol/limits.hpp"
#include "host-sim/page/protocol/server_frames.hpp"
#include "host-sim/page/source.hpp"

namespace smaservo::page {

/// The requests of a conversation to its owner. Answers may come at once or later.
class Desk {
 public:
  virtual ~Desk() = default;
  virtual void send(Frame frame) = 0;
  /// This client has subscribed to a channel, or does not want it any longer.
  virtual void subscribe(std::uint32_t channel, bool wanted) = 0;
  /// Both functions are answered by one parameter_values() with this id.
  virtual void get_parameters(std::vector<std::string> names, std::optional<std::string> id) = 0;
  virtual void set_parameters(std::vector<NamedValue> values, std::optional<std::string> id) = 0;
  /// Answered by one answer() with these numbers.
  virtual void call(std::uint32_t service, std::uint32_t call, std::string request) = 0;
};

class Conversation {
 public:
  /// `services` must outlive the conversation. Nothing is sent before greet().
  Conversation(Desk& desk, const std::vector<Service>& services)
      : desk_(desk), services_(services) {}

  /// Sends server, channels and services: the first messages that a client gets.
  void greet(const ServerInfo& info, const std::vector<Channel>& channels);

  void hear_text(std::string_view text);
  void hear_bytes(std::string_view bytes);

  /// Takes the list of all present channels and sends which have appeared or disappeared. A
  /// client's subscriptions of channels that have disappeared end without a call to the desk.
  void show_channels(const std::vector<Channel>& channels);
  void message(std::uint32_t channel, std::int64_t time_ns,
               const std::shared_ptr<const std::string>& bytes);
  /// Sends the answer to a request for parameters; `refusal` is the reason why nothing was written.
  void parameter_values(std::span<const NamedValue> values, const std::optional<std::string>& id,
                        std::string_view refusal);
  /// Sends those of the changed values that the client has subscribed to.
  void parameters_changed(std::span<const NamedValue> values);
  void answer(std::uint32_t service, std::uint32_t call, Answer answer);

  enum class Level { info, warning, error };
  void status(Level level, std::string_view message);

  std::vector<std::uint32_t> subscribed_channels() const;

 private:
  struct Reading;  ///< reading of one text

  bool may_ask(const char* what);
  void drop_channels(const std::map<std::uint32_t, Channel>& now);

  Desk& desk_;
  const std::vector<Service>& services_;
  std::map<std::uint32_t, Channel> channels_;
  std::map<std::uint32_t, std::uint32_t> by_channel_;       ///< subscription of each channel
  std::map<std::uint32_t, std::uint32_t> by_subscription_;  ///< channel of each subscription
  /// Wanted parameters; the unwanted ones if wants_all_ is set.
  std::set<std::string, std::less<>> named_;
  bool wants_all_ = false;  ///< all parameters are wanted, except those in named_
  std::size_t open_ = 0;    ///< requests that have not been answered yet
};

}  // namespace smaservo::page
