#pragma once
// Four PDOs in each direction, mapped at run time: CiA 301's transmission types 0, 1 to 240, 254
// and 255, inhibit and event timers, answers to remote requests.
//
// Cost per call: at most 32 mapped objects, each found and read or written once.

#include "firmware/canopen/node/communication.hpp"
#include "hal/can_frame.hpp"

namespace smaservo::canopen {

/// The result of a received PDO, as EMCY codes.
enum class PdoEvent : std::uint16_t {
  none = 0,
  ignored = 1,  ///< the frame is no PDO of this node
  too_short = 0x8210,
  too_long = 0x8220,
  timed_out = 0x8250,
};

/// Load per second; `bits` includes all stuff bits that are possible.
struct BusLoad {
  float frames, bits;
};

class Pdos {
 public:
  Pdos(Dictionary& dictionary, Communication& objects)
      : dictionary_(dictionary), objects_(objects) {}

  /// To be called after the objects have been set to other values. An impossible mapping is
  /// cleared.
  void reset();
  /// To be called at each change of the NMT state: waiting PDOs are neither sent nor applied any
  /// more.
  void stop();

  /// Whether an object of 1400h..1BFFh may get this value now.
  Abort check(Key key, std::uint32_t value) const;
  /// To be called when the object has a new value.
  void changed(Key key);

  /// A wrong length is reported once, until a frame of the right length has come.
  PdoEvent receive(const hal::CanFrame& frame, std::uint64_t now_us);
  /// `counter` is that of the SYNC; 0 if it has none.
  void sync(std::uint8_t counter);
  /// Handles events and timers. Returns PdoEvent::timed_out when an RPDO with an event timer is
  /// missing.
  PdoEvent advance(std::uint64_t now_us);
  bool take(hal::CanFrame& frame, std::uint64_t now_us);

  /// The greatest load of the bus by the TPDOs if event-driven values change every `step_s`. TPDOs
  /// of the types 1 to 240 are included only if 1006h gives the period of SYNC.
  BusLoad load(float step_s) const;
  /// The number of RPDOs whose last frame did not have the length of their mapping.
  unsigned wrong_lengths() const;
  bool has_deadline() const;  ///< at least one RPDO has an event timer
  bool on_time() const;       ///< all RPDOs with an event timer are on time

 private:
  struct Transmit {
    std::uint64_t sent_us;
    std::array<std::uint8_t, 8> data;
    std::uint8_t length;
    std::uint8_t syncs;  ///< SYNCs since the PDO was last due
    bool started;        ///< the SYNC with the start value has come
    bool due;
    bool sampled;  ///< `data` were taken at the SYNC
    bool ever;     ///< it has been sent since the start
  };
  struct Receive {
    std::uint64_t came_us;
    std::array<std::uint8_t, 8> data;
    bool waits;    ///< the data are applied at the next SYNC
    bool watched;  ///< it has come once, so that its event timer runs
    bool late;
    /// A wrong length has been reported; cleared by a frame of the right length.
    bool was_short, was_long;
  };

  static Abort check_params(const PdoParams& params, Key key, std::uint32_t value);
  Abort check_mapping(const PdoParams& params, const Mapping& map, Key key,
                      std::uint32_t value) const;
  Abort check_object(std::uint32_t object, bool transmit) const;
  Abort check_count(const Mapping& map, std::uint32_t count, bool transmit) const;
  void apply(const Mapping& map, std::span<const std::uint8_t> data);
  std::uint8_t pack(const Mapping& map, std::array<std::uint8_t, 8>& data);
  void sample(std::size_t i);
  void look(std::size_t i, std::uint64_t now_us);

  Dictionary& dictionary_;
  Communication& objects_;
  std::array<Transmit, pdo_count> tx_{};
  std::array<Receive, pdo_count> rx_{};
};

}  // namespace smaservo::canopen
