#pragma once
// Four PDOs in each direction, mapped at run time: CiA 301's transmission types 0, 1 to 240, 254
// and 255, inhibit and event timers, answers to remote requests.
//
// Cost per call: each mapped object is found and read or written once, at most 32 of them.

#include "firmware/canopen/node/communication.hpp"
#include "hal/can_frame.hpp"

namespace smaservo::canopen {

/// What a received PDO led to, as EMCY codes.
enum class PdoEvent : std::uint16_t {
  none = 0,
  ignored = 1,  ///< no PDO of ours
  too_short = 0x8210,
  too_long = 0x8220,
  timed_out = 0x8250,
};

/// Per second; bits with all stuff bits that there may be.
struct BusLoad {
  float frames, bits;
};

class Pdos {
 public:
  Pdos(Dictionary& dictionary, Communication& objects)
      : dictionary_(dictionary), objects_(objects) {}

  /// To be called after the objects have been given other values. A mapping that is not possible is
  /// cleared.
  void reset();
  /// To be called at each change of the NMT state: what waits is neither sent nor applied any more.
  void stop();

  /// Whether an object of 1400h..1BFFh may get this value now.
  Abort check(Key key, std::uint32_t value) const;
  /// The object has got a new value.
  void changed(Key key);

  /// A wrong length is told once, until a frame of the right length has come.
  PdoEvent receive(const hal::CanFrame& frame, std::uint64_t now_us);
  /// `counter` of the SYNC; 0: it has none.
  void sync(std::uint8_t counter);
  /// Events and timers. PdoEvent::timed_out when an RPDO with an event timer stays away.
  PdoEvent advance(std::uint64_t now_us);
  bool take(hal::CanFrame& frame, std::uint64_t now_us);

  /// What the TPDOs put on the bus at most, if event-driven values change each `step_s`. Those of
  /// types 1 to 240 count where 1006h says how often SYNC comes.
  BusLoad load(float step_s) const;
  /// How many RPDOs had another length than their mapping when they last came.
  unsigned wrong_lengths() const;
  bool has_deadline() const;  ///< some RPDO has an event timer
  bool on_time() const;       ///< all RPDOs with an event timer have come in time

 private:
  struct Transmit {
    std::uint64_t sent_us;
    std::array<std::uint8_t, 8> data;
    std::uint8_t length;
    std::uint8_t syncs;  ///< SYNCs since the PDO was last due
    bool started;        ///< the SYNC with the start value has come
    bool due;
    bool sampled;  ///< its data are those of the SYNC
    bool ever;     ///< sent since the start
  };
  struct Receive {
    std::uint64_t came_us;
    std::array<std::uint8_t, 8> data;
    bool waits;    ///< for the next SYNC
    bool watched;  ///< it has come once: its event timer runs
    bool late;
    bool was_short, was_long;  ///< since the last frame of the right length
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
