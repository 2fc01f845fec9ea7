// load INTERFACE NODE SECONDS: a master that asks much of a servo: SYNC, four RPDOs and four TPDOs
// in each millisecond, and SDO transfers one after the other, of values and of the data sheet by
// blocks. Prints how long answers take, and ends with 1 where a set-point or a TPDO has been lost.

#include <array>
#include <exception>
#include <fmt/format.h>
#include <poll.h>
#include <string>

#include "firmware/canopen/object.hpp"
#include "firmware/daemon/histogram.hpp"
#include "hal/linux/can_socket.hpp"
#include "hal/linux/clock.hpp"

namespace smaservo {
namespace {

using canopen::put_number;
using canopen::take_number;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t patience_ns = 2000 * ms;

/// SDO transfers one after the other: a value, then the data sheet by blocks. Times run from each
/// request that must be answered to the first frame of its answer.
class Transfers {
 public:
  Transfers(CanSocket& port, std::uint32_t node) : port_(port), node_(node) {}

  void begin() { ask(at_ % 10 == 9 ? block_request : value_request); }
  void receive(const CanFrame& frame) {
    if (asked_ns_ != 0) {
      const std::int64_t took_ns = monotonic_ns() - asked_ns_;
      times_.add(took_ns);
      asked_ns_ = 0;
    }
    if (frame.data[0] == 0x80) {
      ++aborts_;
      next();
    } else if (segment_ >= 0) {
      receive_segment(frame);
    } else if (ending_) {
      ending_ = false;
      send({0xA1});
      ++blocks_;
      next();
    } else if ((frame.data[0] & 0xE0U) == 0xC0) {
      segment_ = 0;
      ask({0xA3});
    } else {
      next();
    }
  }

  const Histogram& times() const { return times_; }
  int aborts() const { return aborts_; }
  int blocks() const { return blocks_; }
  int lost_segments() const { return lost_segments_; }
  std::uint64_t bytes() const { return bytes_; }
  bool waits_longer_than(std::int64_t ns) const {
    return asked_ns_ != 0 && monotonic_ns() - asked_ns_ > ns;
  }

 private:
  using Bytes = std::array<std::uint8_t, 8>;
  static constexpr std::uint8_t block_size = 127;
  static constexpr Bytes value_request{0x40, 0x18, 0x10, 4};
  static constexpr Bytes block_request{0xA4, 0x21, 0x10, 0, block_size, 0};

  void send(const Bytes& data) { port_.send({.id = 0x600U + node_, .length = 8, .data = data}); }
  void ask(const Bytes& data) {
    send(data);
    asked_ns_ = monotonic_ns();
  }
  void next() {
    ++at_;
    begin();
  }
  void receive_segment(const CanFrame& frame) {
    const int number = frame.data[0] & 0x7F;
    const bool last = (frame.data[0] & 0x80U) != 0;
    if (number == segment_ + 1) {
      segment_ = number;
      bytes_ += 7;
    } else {
      ++lost_segments_;
    }
    if (number == block_size || last) {
      ending_ = last && number == segment_;
      const auto received = static_cast<std::uint8_t>(segment_);
      segment_ = ending_ ? -1 : 0;
      ask({0xA2, received, block_size});
    }
  }

  CanSocket& port_;
  std::uint32_t node_;
  Histogram times_;
  std::int64_t asked_ns_ = 0;
  int at_ = 0, segment_ = -1, aborts_ = 0, blocks_ = 0, lost_segments_ = 0;
  std::uint64_t bytes_ = 0;
  bool ending_ = false;
};

class Master {
 public:
  Master(const char* interface, std::uint32_t node)
      : port_(interface), node_(node), transfers_(port_, node) {}

  void set_up() {
    for (std::uint16_t i = 0; i < 4; ++i) {
      const auto rpdo = static_cast<std::uint16_t>(0x1400 + i);
      const auto tpdo = static_cast<std::uint16_t>(0x1800 + i);
      set({tpdo, 1}, 0xC000'0000U | (0x180U + 0x100U * i + node_), 4);
      set({tpdo, 2}, 1, 1);
      set({tpdo, 5}, 0, 2);
      set({rpdo, 1}, 0x8000'0000U | (0x200U + 0x100U * i + node_), 4);
    }
    map(0x1602, {0x2201'0120});
    map(0x1603, {0x2201'0320});
    map(0x1A01, {0x607A'0020, 0x6064'0020});
    map(0x1A02, {0x2200'0C20, 0x2200'0A20});
    map(0x1A03, {0x2200'0620, 0x2200'0320});
    for (std::uint16_t i = 0; i < 4; ++i) {
      set({static_cast<std::uint16_t>(0x1800 + i), 1}, 0x4000'0000U | (0x180U + 0x100U * i + node_),
          4);
      set({static_cast<std::uint16_t>(0x1400 + i), 1}, 0x200U + 0x100U * i + node_, 4);
    }
    port_.send({.id = 0, .length = 2, .data = {1, static_cast<std::uint8_t>(node_)}});
    set({0x6060, 0}, 8, 1);
    for (const std::uint16_t word : std::array<std::uint16_t, 3>{6, 7, 15}) {
      set({0x6040, 0}, word, 2);
      rest(300 * ms);
    }
    if ((get({0x6041, 0}) & 0x6FU) != 0x27) {
      throw std::runtime_error(fmt::format("not enabled: statusword {:04X}h, error {:04X}h",
                                           get({0x6041, 0}), get({0x603F, 0})));
    }
  }

  void run(int seconds) {
    const std::int64_t cycles = 1000L * seconds;
    std::int64_t at_ns = monotonic_ns() + 2 * ms;
    transferring_ = true;
    tpdos_ = 0;
    transfers_.begin();
    for (std::int64_t k = 0; k < cycles; ++k, at_ns += ms) {
      listen_until(at_ns);
      send(0x80, 0, 0);
      // Between two SYNCs: which of them shows a set-point is certain.
      listen_until(at_ns + 3 * ms / 4);
      check_answers();
      target_ = zigzag(k);
      send(0x200 + node_, 3, 0x08'000FU);
      send(0x300 + node_, 8, static_cast<std::uint32_t>(target_));
      send(0x400 + node_, 4, 0);
      send(0x500 + node_, 4, 0);
    }
    if (transfers_.waits_longer_than(1000 * ms)) {
      throw std::runtime_error("an SDO request is not answered");
    }
  }

  /// Whether all is well.
  bool report() {
    const Histogram& t = transfers_.times();
    const auto us = [](std::int64_t ns) { return static_cast<double>(ns) / 1e3; };
    fmt::print("LOAD answers {} p50 {:.0f} p99 {:.0f} p99_9 {:.0f} max {:.0f} us\n", t.count(),
               us(t.quantile_ns(0.5)), us(t.quantile_ns(0.99)), us(t.quantile_ns(0.999)),
               us(t.greatest_ns()));
    fmt::print("LOAD sheets {} bytes {} lost_segments {} aborts {}\n", transfers_.blocks(),
               transfers_.bytes(), transfers_.lost_segments(), transfers_.aborts());
    fmt::print("LOAD setpoints {} lost {} lost_tpdos {} skipped_by_the_loop {}\n", checked_, lost_,
               lost_tpdos_, skipped_);
    fmt::print("LOAD statusword {:04X}h\n", status_);
    constexpr double most_us = 15'000, usual_us = 5000;
    return checked_ > 0 && lost_ == 0 && lost_tpdos_ == 0 && transfers_.aborts() == 0 &&
           transfers_.blocks() > 0 && us(t.quantile_ns(0.99)) < usual_us &&
           us(t.greatest_ns()) <= most_us && (status_ & 0x6FU) == 0x27;
  }

 private:
  /// Up and down by 1 um in each cycle: no two in succession are the same.
  static std::int32_t zigzag(std::int64_t k) {
    constexpr std::int64_t least = 400, span = 40;
    const std::int64_t at = k % (2 * span);
    return static_cast<std::int32_t>(least + (at < span ? at : 2 * span - at));
  }

  void send(std::uint32_t id, std::uint8_t length, std::uint64_t value) {
    CanFrame frame{.id = id, .length = length};
    put_number(frame.data, value);
    port_.send(frame);
  }
  void rest(std::int64_t ns) { listen_until(monotonic_ns() + ns); }
  void listen_until(std::int64_t at_ns) {
    for (;;) {
      CanFrame frame;
      while (port_.receive(frame)) {
        take(frame);
      }
      const std::int64_t left_ns = at_ns - monotonic_ns();
      if (left_ns <= 0) {
        return;
      }
      pollfd readable{port_.descriptor(), POLLIN, 0};
      const timespec time{left_ns / 1'000'000'000, static_cast<long>(left_ns % 1'000'000'000)};
      ppoll(&readable, 1, &time, nullptr);
    }
  }
  void take(const CanFrame& frame) {
    if (frame.id == 0x580 + node_) {
      if (transferring_) {
        transfers_.receive(frame);
      }
      answer_ = frame;
      answered_ = true;
    } else if (frame.id == 0x180 + node_) {
      status_ = static_cast<std::uint16_t>(take_number(std::span(frame.data).first(2)));
      ++tpdos_;
    } else if (frame.id == 0x280 + node_) {
      shown_ = static_cast<std::int32_t>(take_number(std::span(frame.data).first(4)));
      ++tpdos_;
    } else if (frame.id == 0x380 + node_) {
      const auto bits = static_cast<std::uint32_t>(take_number(std::span(frame.data).first(4)));
      in_force_um_ = 1e6F * canopen::as_real(bits);
      ++tpdos_;
    } else if (frame.id == 0x480 + node_) {
      ++tpdos_;
    }
  }
  /// After a SYNC: the four TPDOs have come, with the last set-point.
  void check_answers() {
    lost_tpdos_ += 4 - tpdos_;
    tpdos_ = 0;
    if (target_ != 0) {
      ++checked_;
      lost_ += shown_ == target_ ? 0 : 1;
      // The loop's own, one or two turns later.
      const float step_um = in_force_um_ - before_um_;
      skipped_ += before_um_ != 0 && std::abs(step_um) > 1.5F ? 1 : 0;
      before_um_ = in_force_um_;
    }
  }

  std::uint32_t ask(std::uint8_t command, Key key, std::uint32_t value) {
    CanFrame request{.id = 0x600 + node_, .length = 8};
    request.data = {command, static_cast<std::uint8_t>(key.index),
                    static_cast<std::uint8_t>(key.index >> 8U), key.sub};
    put_number(std::span(request.data).subspan(4), value);
    answered_ = false;
    port_.send(request);
    const std::int64_t end_ns = monotonic_ns() + patience_ns;
    while (!answered_ && monotonic_ns() < end_ns) {
      rest(ms / 10);
    }
    const auto number = static_cast<std::uint32_t>(take_number(std::span(answer_.data).subspan(4)));
    if (!answered_ || answer_.data[0] == 0x80) {
      throw std::runtime_error(
          fmt::format("{:04X}h:{}: {}", key.index, key.sub,
                      answered_ ? fmt::format("abort {:08X}h", number) : std::string("no answer")));
    }
    return number;
  }
  void set(Key key, std::uint32_t value, unsigned size) {
    ask(static_cast<std::uint8_t>(0x23U | (4U - size) << 2U), key, value);
  }
  std::uint32_t get(Key key) { return ask(0x40, key, 0); }
  void map(std::uint16_t index, std::initializer_list<std::uint32_t> objects) {
    set({index, 0}, 0, 1);
    std::uint8_t sub = 0;
    for (const std::uint32_t object : objects) {
      set({index, ++sub}, object, 4);
    }
    set({index, 0}, sub, 1);
  }

  CanSocket port_;
  std::uint32_t node_;
  Transfers transfers_;
  CanFrame answer_{};
  bool answered_ = false, transferring_ = false;
  std::uint16_t status_ = 0;
  std::int32_t target_ = 0, shown_ = 0;
  float in_force_um_ = 0, before_um_ = 0;
  int tpdos_ = 0;
  std::int64_t checked_ = 0, lost_ = 0, lost_tpdos_ = 0, skipped_ = 0;
};

}  // namespace
}  // namespace smaservo

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "load INTERFACE NODE SECONDS\n");
    return 2;
  }
  try {
    smaservo::Master master(argv[1], static_cast<std::uint32_t>(std::stoul(argv[2])));
    master.set_up();
    master.run(std::stoi(argv[3]));
    return master.report() ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "load: {}\n", error.what());
    return 1;
  }
}
