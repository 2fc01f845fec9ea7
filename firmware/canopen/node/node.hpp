#pragma once
// A CANopen node: NMT slave, heartbeats, SYNC, EMCY, SDO, PDO, LSS over the objects 1000h..1FFFh;
// all others are the application's. Frames in, frames out, time as an argument; one thread.
//
//   start() -> receive(), advance(), take() ... -> request() -> start() after a reset
//
// Cost per call: bounded by four PDOs of eight objects; see pdo.hpp.

#include <string_view>

#include "firmware/canopen/node/lss.hpp"
#include "firmware/canopen/node/pdo.hpp"
#include "firmware/canopen/node/sdo_server.hpp"

namespace smaservo::canopen {

enum class Supervision : std::uint8_t { none, alive, gone };

enum class Nmt : std::uint8_t {
  initialising = 0,
  stopped = 4,
  operational = 5,
  pre_operational = 127
};

/// What the owner of the node has to do, off the bus. The answer is finish() with the request's
/// number, or start() after a reset. A reset takes the place of a request that waits: the result of
/// that one has its number, and answers nothing any more.
enum class Request : std::uint8_t {
  none,
  store_all,            ///< settings and image(), durable before the answer
  store_communication,  ///< the image
  store_application,    ///< the settings
  restore_all,          ///< deletes what is stored; the defaults are in force after a reset
  restore_communication,
  restore_application,
  store_lss,  ///< the image: node-id and bit rate have changed
  bit_rate,   ///< changes to Node::bit_rate() after Node::bit_rate_delay_ms()
  reset_node,
  reset_communication,
};

// EMCY codes: the command source has gone.
inline constexpr std::uint16_t sync_lost = 0x8100;  ///< a SYNC that 1006h watches
inline constexpr std::uint16_t heartbeat_lost = 0x8130;

/// A table of objects and the plain struct that they live in.
struct ObjectTable {
  ObjectRows rows;
  std::span<std::byte> memory;
};

/// What stands behind the node: the objects beyond 1FFFh, and what follows from the bus.
class Application : public Dictionary {
 public:
  /// Whether this node has the communication object.
  virtual bool offers(Key /*key*/) const { return true; }
  /// Objects with fixed defaults, some of them `stored` in the image.
  virtual ObjectTable table() { return {}; }
  /// After every start: objects have their defaults, or what the image says.
  virtual void started(std::uint8_t node_id) = 0;
  virtual void nmt_changed(Nmt /*state*/) {}
  /// The command source has gone; `code` is that of the EMCY.
  virtual void connection_lost(std::uint16_t /*code*/) {}
  /// Whether the request may go to the owner now: Abort::none, or why not.
  virtual Abort may_request(Request /*request*/) const { return Abort::none; }
  /// Whether objects of this level may be written now.
  virtual bool may_write(Level /*level*/) const { return true; }
  /// An object of the node that is stored has changed, or a write of any object has been refused
  /// before it came to the application.
  virtual void written(Key /*key*/, std::uint32_t /*old_value*/, std::uint32_t /*value*/,
                       Source /*source*/, Abort /*result*/) {}

 protected:
  ~Application() = default;
};

struct NodeConfig {
  std::uint32_t device_type = 0;
  std::array<std::uint32_t, 4> identity{};  ///< vendor, product, revision, serial number
  std::string_view device_name, hardware_version, software_version;
  std::uint8_t node_id = unconfigured;  ///< used where the image has none
  std::uint8_t bit_rate = 0;            ///< in force; an index of CiA 305's table
  std::uint16_t bit_rates = 0;          ///< those that LSS may choose; bit i: entry i of the table
  std::string_view eds;                 ///< for 1021h; empty: there is none
};

class Node final : public Dictionary {
 public:
  /// `buffer` holds the longest value that can be written, at least 8 bytes.
  Node(const NodeConfig& config, Application& application, std::span<std::uint8_t> buffer)
      : config_(config),
        application_(application),
        sdo_(*this, buffer),
        pdos_(*this, objects_),
        lss_(config.identity, config.bit_rates) {}

  /// After switching on and after each reset. The image is what image() once gave; an empty or
  /// damaged one means defaults. False: it is damaged.
  bool start(std::span<const std::uint8_t> image, std::uint64_t now_us);
  void receive(const hal::CanFrame& frame, std::uint64_t now_us);
  void advance(std::uint64_t now_us);
  /// The next frame to send, the most urgent first.
  bool take(hal::CanFrame& frame);

  Request request() const { return request_; }
  /// Of request(); each request has a new one.
  std::uint32_t request_number() const { return request_number_; }
  /// Answers the request of this number; without effect if it waits no longer. A reset is answered
  /// by start() instead.
  void finish(std::uint32_t number, bool done);
  /// Passes a request of the application on to the owner. Abort::pending: finish() will answer it.
  Abort ask(Request request);

  /// Largest image.
  static constexpr std::size_t image_size = 1280;
  /// Writes what 1010h stores beside the settings, as bytes: changed objects, node-id and bit rate.
  /// Returns their number.
  std::size_t image(std::span<std::uint8_t> to) const;
  /// To be called when the node-id has been set by other means: that of LSS is no longer used.
  void forget_lss_node_id() { lss_node_id_ = lss_before_.node_id = 0; }

  /// Sends an EMCY with the present 1001h and remembers it in 1003h; to be called once, when its
  /// condition begins, after set_errors(). `info` are the five bytes of the manufacturer.
  void emergency(std::uint16_t code, std::uint64_t info = 0);
  /// Bits of 1001h that the application answers for. Sends "error reset" when some have gone.
  void set_errors(std::uint8_t bits);
  /// To be called when something that can be stored has changed: 1020h is cleared.
  void touch() { objects_.verify = {}; }

  Nmt state() const { return state_; }
  std::uint8_t node_id() const { return node_id_; }
  std::uint8_t bit_rate() const { return lss_.pending_bit_rate(); }
  BusLoad pdo_load(float step_s) const { return pdos_.load(step_s); }
  std::uint16_t bit_rate_delay_ms() const { return lss_.delay_ms(); }
  /// Somebody else answers to the same node-id.
  bool is_duplicated() const { return duplicated_; }
  /// What the configured supervision tells of the command source: all heartbeats of 1016h, else the
  /// event timers of RPDOs. SYNC, where 1006h watches it, can only tell that the source has gone,
  /// since another node may send it.
  Supervision supervision() const;
  /// The EMCY code of what supervision() misses; 0: nothing.
  std::uint16_t missing() const;
  /// When the last SDO request came.
  std::uint64_t last_sdo_us() const { return sdo_.last_request_us(); }
  void set_sdo_timeouts(const SdoTimeouts& timeouts) { sdo_.set_timeouts(timeouts); }
  Communication& objects() { return objects_; }

  Abort find(Key key, Entry& entry) const override;
  Abort read(const Entry& entry, std::uint32_t offset, std::span<std::uint8_t> to) override;
  Abort write(const Entry& entry, std::span<const std::uint8_t> from, Source source) override;
  void refused(const Entry& entry, std::span<const std::uint8_t> from, Abort why) override;

 private:
  struct Consumer {
    std::uint64_t came_us;
    bool alive, lost;
  };
  struct Emergency {
    std::uint64_t info;
    std::uint16_t code;
    std::uint8_t errors;
  };

  bool is_ours(Key key) const;
  Abort write_own(const Object& object, std::uint32_t value);
  Abort check(Key key, std::uint32_t value) const;
  Abort check_signature(Key key, std::uint32_t value);
  Abort check_consumer(Key key, std::uint32_t value) const;
  void written(Key key);
  std::string_view text_of(std::uint16_t index) const;
  bool load_image(std::span<const std::uint8_t> image, bool keeps_node_id);
  std::byte* memory();

  void raise(Request request);
  void command(const hal::CanFrame& frame);
  void store_lss();
  void enter(Nmt state);
  void receive_sync(const hal::CanFrame& frame);
  void receive_heartbeat(const hal::CanFrame& frame);
  void receive_lss(const hal::CanFrame& frame);
  void watch_consumers();
  void watch_sync();
  void lose(std::uint16_t code, std::uint8_t who);
  void find_again();
  void remember(std::uint16_t code, std::uint64_t info);
  void queue(const Emergency& emergency);
  void show_errors();
  bool take_heartbeat(hal::CanFrame& frame);
  bool take_emergency(hal::CanFrame& frame);
  bool take_answer(hal::CanFrame& frame);
  bool communicates() const { return state_ == Nmt::operational || state_ == Nmt::pre_operational; }

  NodeConfig config_;
  Application& application_;
  Communication objects_{};
  SdoServer sdo_;
  Pdos pdos_;
  Lss lss_;
  std::array<Consumer, consumer_count> consumers_{};
  std::array<Emergency, error_history> emergencies_{};
  std::uint64_t now_us_ = 0, heartbeat_us_ = 0, emergency_us_ = 0, sync_us_ = 0;
  std::uint8_t emergencies_waiting_ = 0;
  std::uint8_t node_id_ = unconfigured;
  std::uint8_t lss_node_id_ = 0;  ///< stored by LSS; 0: none
  std::uint8_t lss_bit_rate_ = unconfigured;
  struct {
    std::uint8_t node_id, bit_rate;
  } lss_before_{};          ///< of the two above, in case that they cannot be stored
  bool lss_waits_ = false;  ///< the answer to store_lss
  std::uint8_t application_errors_ = 0;
  unsigned conditions_ = 0;  ///< of the bus that are present, as last shown in 1001h
  Nmt state_ = Nmt::initialising;
  Request request_ = Request::none;
  std::uint32_t request_number_ = 0;
  bool boots_ = false;  ///< the boot-up message has to be sent
  bool emergency_sent_ = false;
  bool sync_alive_ = false;
  bool lost_ = false;        ///< somebody who is watched has gone
  bool wrong_sync_ = false;  ///< the last SYNC had another length than 1019h says
  bool duplicated_ = false;
};

}  // namespace smaservo::canopen
