#pragma once
// The interface of what the socket serves: channels of messages, parameters, services. The server
// knows nothing of servos, and the source nothing of sockets. PROTOCOL.md describes the content.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace smaservo::page {

enum class Encoding : std::uint8_t {
  json,  ///< with a JSON schema
  cdr,   ///< ROS 2's encoding, with a ROS 2 message definition
};

struct Channel {
  std::uint32_t id;
  std::string topic;
  std::string schema_name;
  std::string schema;  ///< schema of its messages
  Encoding encoding = Encoding::json;
};

struct Service {
  std::uint32_t id;
  std::string name;
  std::string request_schema, response_schema;  ///< JSON schemas
};

/// A parameter of the Foxglove protocol: `value` is JSON.
struct NamedValue {
  std::string name;
  std::string value;
};

/// The client that makes a request. A read-only client is refused anything that writes, whoever has
/// control.
struct Caller {
  std::uint32_t client;
  bool read_only;
};

/// `text` is JSON if ok, otherwise the error, for a person.
struct Answer {
  bool ok;
  std::string text;
};

/// The state of a client's queue.
struct ClientState {
  std::uint32_t client;
  std::string address;
  std::uint64_t queued, dropped;
  bool read_only;
};

/// The receiver of a source's messages that are no answers to requests. All functions may be called
/// from any thread and never block.
class Sink {
 public:
  virtual ~Sink() = default;
  /// Sends a message of a channel to all clients that have subscribed to it.
  virtual void message(std::uint32_t channel, std::int64_t time_ns,
                       std::shared_ptr<const std::string> bytes) = 0;
  /// Called when the list of channels has changed, because servos have appeared or disappeared.
  virtual void channels_changed() = 0;
  /// Sends parameters that have new values.
  virtual void parameters_changed(const std::vector<NamedValue>& values) = 0;
  /// The present state of all clients.
  virtual std::vector<ClientState> clients() = 0;
};

/// All functions are called from the server's thread and return at once; callbacks come later, from
/// any thread.
class Source {
 public:
  virtual ~Source() = default;
  virtual void start(Sink& sink) = 0;
  /// Ends the source's threads; heat that the source has switched on is off on return.
  virtual void stop() = 0;

  virtual std::vector<Channel> channels() = 0;
  virtual std::vector<Service> services() = 0;
  /// Tells how many clients have subscribed to a channel. Unwanted values need not be read from the
  /// bus. The subscriptions of a removed channel have ended, without a call of this function.
  virtual void subscribed(std::uint32_t channel, unsigned clients) = 0;

  /// An empty list of names requests all parameters.
  virtual void get_parameters(std::vector<std::string> names,
                              std::function<void(std::vector<NamedValue>)> reply) = 0;
  /// Writes all values or none. `reply` gets the values in force, and the reason if the set was
  /// refused, otherwise "".
  virtual void set_parameters(
      Caller caller, std::vector<NamedValue> values,
      std::function<void(std::vector<NamedValue>, std::string refusal)> reply) = 0;
  virtual void call(Caller caller, std::uint32_t service, std::string request,
                    std::function<void(Answer)> reply) = 0;
  virtual void client_left(std::uint32_t client) = 0;
};

}  // namespace smaservo::page
