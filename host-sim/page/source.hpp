#pragma once
// What the socket serves, as an interface: channels that give messages, parameters, services. The
// server knows nothing of servos, and the source nothing of sockets. PROTOCOL.md has what is said.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace smaservo::page {

enum class Encoding : std::uint8_t {
  json,  ///< with a JSON schema
  cdr,   ///< ROS 2's bytes, with a ROS 2 message definition
};

struct Channel {
  std::uint32_t id;
  std::string topic;
  std::string schema_name;
  std::string schema;  ///< of its messages
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

/// Who asks. A read-only client is refused what writes, whoever has control.
struct Caller {
  std::uint32_t client;
  bool read_only;
};

/// `text` is JSON when ok, else what went wrong, for a person.
struct Answer {
  bool ok;
  std::string text;
};

/// How a client's queue stands.
struct ClientState {
  std::uint32_t client;
  std::string address;
  std::uint64_t queued, dropped;
  bool read_only;
};

/// Where a source sends what nobody has asked for. All functions may be called from any thread and
/// never wait.
class Sink {
 public:
  virtual ~Sink() = default;
  /// A message of a channel; everybody who has subscribed gets it.
  virtual void message(std::uint32_t channel, std::int64_t time_ns,
                       std::shared_ptr<const std::string> bytes) = 0;
  /// The list of channels is another one: servos have come or gone.
  virtual void channels_changed() = 0;
  /// Parameters that have new values.
  virtual void parameters_changed(const std::vector<NamedValue>& values) = 0;
  /// All clients, as they stand now.
  virtual std::vector<ClientState> clients() = 0;
};

/// All functions are called from the server's thread and return at once; callbacks come later, from
/// any thread.
class Source {
 public:
  virtual ~Source() = default;
  virtual void start(Sink& sink) = 0;
  /// Ends its threads; heat that it has switched on is off when this returns.
  virtual void stop() = 0;

  virtual std::vector<Channel> channels() = 0;
  virtual std::vector<Service> services() = 0;
  /// How many clients want a channel. What nobody wants need not be read from the bus. When a
  /// channel has been removed nobody wants it any more, and this is not called for it.
  virtual void subscribed(std::uint32_t channel, unsigned clients) = 0;

  /// An empty list of names asks for all.
  virtual void get_parameters(std::vector<std::string> names,
                              std::function<void(std::vector<NamedValue>)> reply) = 0;
  /// One set: all or none. `reply` gets the values in force, and why a set was refused, or "".
  virtual void set_parameters(
      Caller caller, std::vector<NamedValue> values,
      std::function<void(std::vector<NamedValue>, std::string refusal)> reply) = 0;
  virtual void call(Caller caller, std::uint32_t service, std::string request,
                    std::function<void(Answer)> reply) = 0;
  virtual void client_left(std::uint32_t client) = 0;
};

}  // namespace smaservo::page
