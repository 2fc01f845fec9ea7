#pragma once
// A CANopen node: NMT slave, heartbeats, SYNC, EMCY, SDO, PDO, LSS over the objects 1000h..1FFFh;
// all other objects belong to the application. Frames in, frames out, time as an argument; one
// thread.
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

/// A task for the owner of the node, to be done apart from the bus. The owner answers by finish()
/// with the request's number, or by start() after a reset. A reset replaces a waiting request: the
/// result of the replaced one, which carries the old number, is then ignored.
enum class Request : std::uint8_t {
  none,
  store_all,            ///< store the settings and image() durably before answering
  store_communication,  ///< store image()
  store_application,    ///< store the settings
  restore_all,          ///< delete what is stored; the defaults take effect after a reset
  restore_communication,
  restore_application,
  store_lss,  ///< store image(), because node-id or bit rate have changed
  bit_rate,   ///< change to Node::bit_rate() after Node::bit_rate_delay_ms()
  reset_node,
  reset_communication,
};

// EMCY codes for the loss of the command source.
inline constexpr std::uint16_t sync_lost = 0x8100;  ///< the SYNC that 1006h watches is missing
inline constexpr std::uint16_t heartbeat_lost = 0x8130;

/// A table of objects and the plain struct that holds their values.
struct ObjectTable {
  ObjectRows rows;
  std::span<std::byte> memory;
};

/// The application behind the node: the objects beyond 1FFFh, and its reactions to the bus.
class Application : public Dictionary {
 public:
  /// Whether this node has the given communication object.
  virtual bool offers(Key /*key*/) const { return true; }
  /// Objects with fixed defaults, some of them `stored` in the image.
  virtual ObjectTable table() { return {}; }
  /// Called after every start, when objects have their defaults or the values of the image.
  virtual void started(std::uint8_t node_id) = 0;
  virtual void nmt_changed(Nmt /*state*/) {}
  /// Called when the command source has been lost; `code` is that of the EMCY.
  virtual void connection_lost(std::uint16_t /*code*/) {}
  /// Abort::none if the request may be passed to the owner now, otherwise the reason why not.
  virtual Abort may_request(Request /*request*/) const { return Abort::none; }
  /// Whether objects of this level may be written now.
  virtual bool may_write(Level /*level*/) const { return true; }
  /// Called when a stored object of the node has changed, or when a write of any object was refused
  /// before it reached the application.
  virtual void written(Key /*key*/, std::uint32_t /*old_value*/, std::uint32_t /*value*/,
                       Source /*source*/, Abort /*result*/) {}

 protected:
  ~Application() = default;
};

struct NodeConfig {
  std::uint32_t device_type = 0;
  std::array<std::uint32_t, 4> identity{};  ///< vendor, product, revision, serial number
  std::string_view device_name, hardware_version, software_version;
  std::uint8_t node_id = unconfigured;  ///< used if the image has no node-id
  std::uint8_t bit_rate = 0;            ///< bit rate in force, an index of CiA 305's table
  std::uint16_t bit_rates = 0;  ///< bit rates that LSS may choose; bit i: entry i of the table
  std::string_view eds;         ///< text of 1021h; empty: the object does not exist
};

class Node final : public Dictionary {
 public:
  /// `buffer` must hold the longest value that can be written, at least 8 bytes.
  Node(const NodeConfig& config, Application& application, std::span<std::uint8_t> buffer)
      : config_(config),
        application_(application),
        sdo_(*this, buffer),
        pdos_(*this, objects_),
        lss_(config.identity, config.bit_rates) {}

  /// To be called after switching on and after each reset, with bytes that image() gave before;
  /// empty or damaged ones mean defaults. False if they are damaged.
  bool start(std::span<const std::uint8_t> image, std::uint64_t now_us);
  void receive(const hal::CanFrame& frame, std::uint64_t now_us);
  void advance(std::uint64_t now_us);
  /// Gives the next frame to send, the most urgent first; false if there is none.
  bool take(hal::CanFrame& frame);

  Request request() const { return request_; }
  /// The number of request(); each request has a new one.
  std::uint32_t request_number() const { return request_number_; }
  /// Answers the request with this number; has no effect if that request no longer waits. A reset
  /// is answered by start() instead.
  void finish(std::uint32_t number, bool done);
  /// Passes a request of the application on to the owner. Abort::pending: finish() will answer it
  /// later.
  Abort ask(Request request);

  /// Largest image.
  static constexpr std::size_t image_size = 1280;
  /// Writes the bytes that 1010h stores besides the settings: changed objects, node-id and bit
  /// rate. Returns how many bytes these are.
  std::size_t image(std::span<std::uint8_t> to) const;
  /// To be called when the node-id has been set by other means, so that the one set by LSS is no
  /// longer used.
  void forget_lss_node_id() { lss_node_id_ = lss_before_.node_id = 0; }

  /// Sends an EMCY with the present 1001h and adds it to 1003h; to be called once, when its
  /// condition begins, after set_errors(). `info` are the five manufacturer-specific bytes.
  void emergency(std::uint16_t code, std::uint64_t info = 0);
  /// Sets the bits of 1001h that the application controls. Sends an EMCY "error reset" when a bit
  /// is cleared.
  void set_errors(std::uint8_t bits);
  /// To be called when a storable value has changed: clears 1020h.
  void touch() { objects_.verify = {}; }

  Nmt state() const { return state_; }
  std::uint8_t node_id() const { return node_id_; }
  std::uint8_t bit_rate() const { return lss_.pending_bit_rate(); }
  BusLoad pdo_load(float step_s) const { return pdos_.load(step_s); }
  std::uint16_t bit_rate_delay_ms() const { return lss_.delay_ms(); }
  /// Whether another node uses the same node-id.
  bool is_duplicated() const { return duplicated_; }
  /// The state of the command source by the configured supervision: all heartbeats of 1016h, or
  /// otherwise the event timers of RPDOs. The SYNC watched by 1006h can only show that the source
  /// is lost, since another node may send the SYNC.
  Supervision supervision() const;
  /// The EMCY code of the loss that supervision() finds; 0: none.
  std::uint16_t missing() const;
  /// The time at which the last SDO request came.
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
  std::uint8_t lss_node_id_ = 0;  ///< node-id set by LSS; 0: none
  std::uint8_t lss_bit_rate_ = unconfigured;
  struct {
    std::uint8_t node_id, bit_rate;
  } lss_before_{};          ///< the two values above before a store, restored if it fails
  bool lss_waits_ = false;  ///< the answer to store_lss is still due
  std::uint8_t application_errors_ = 0;
  unsigned conditions_ = 0;  ///< number of errors of the bus, as last shown in 1001h
  Nmt state_ = Nmt::initialising;
  Request request_ = Request::none;
  std::uint32_t request_number_ = 0;
  bool boots_ = false;  ///< the boot-up message has to be sent
  bool emergency_sent_ = false;
  bool sync_alive_ = false;
  bool lost_ = false;        ///< a watched source has been lost
  bool wrong_sync_ = false;  ///< the last SYNC did not have the length that 1019h implies
  bool duplicated_ = false;
};

}  // namespace smaservo::canopen
