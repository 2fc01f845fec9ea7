// load INTERFACE NODE SECONDS: a master that asks much of a servo: SYNC, four RPDOs and four TPDOs
// in each millisecond, and SDO transfers one after the other, of values and of the data sheet by
// blocks. Prints how long answers take, and ends with 1 where a set-point or a TPDO has been lost.
// A set-point is lost where the answers to the SYNC after it do not show it, however late they
// come.

#include <algorithm>
#include <array>
#include <ctime>
#include <exception>
#include <fmt/format.h>
#include <linux/sockios.h>
#include <random>
#include <string>
#include <sys/ioctl.h>

#include "firmware/canopen/node/object.hpp"
#include "firmware/daemon/loop/histogram.hpp"
#include "hal/linux/can/can_socket.hpp"

namespace smaservo {
namespace {

using canopen::put_number;
using canopen::take_number;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t patience_ns = 2000 * ms;

std::int64_t ns_of(const timespec& time) {
  return time.tv_sec * 1000 * ms + time.tv_nsec;
}
/// Of the clock that the kernel stamps frames with.
std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return ns_of(now);
}
void sleep_until(std::int64_t ns) {
  const timespec until{ns / (1000 * ms), ns % (1000 * ms)};
  clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &until, nullptr);
}
/// When the kernel has got the last frame that was read.
std::int64_t stamp_ns(const hal::CanSocket& port) {
  timespec stamp{};
  return ioctl(port.descriptor(), SIOCGSTAMPNS, &stamp) == 0 ? ns_of(stamp) : now_ns();
}

/// SDO transfers one after the other: values, then the data sheet by blocks. Times run from each
/// request that must be answered to the first frame of its answer. Answers come as fast as the
/// servo makes them; requests pause for as long as two frames in a millisecond would have taken,
/// which is more than the PDOs leave free on a bus of 1 Mbit/s.
class Transfers {
 public:
  Transfers(hal::CanSocket& port, std::uint32_t node) : port_(port), node_(node) {}

  void begin() { plan(at_ % 10 == 9 ? block_request : value_request); }
  /// Sends what is due.
  void advance() {
    if (due_ns_ != 0 && due_ns_ <= now_ns()) {
      due_ns_ = 0;
      asked_ns_ = now_ns();
      send(planned_);
    }
  }
  /// When advance() will have something to send; 0: an answer comes first.
  std::int64_t due_ns() const { return due_ns_; }
  void receive(const hal::CanFrame& frame, std::int64_t came_ns) {
    if (asked_ns_ != 0) {
      times_.add(came_ns - asked_ns_);
      asked_ns_ = 0;
    }
    ++frames_;
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
      block_size_ = first_size;
      plan({0xA3});
    } else {
      next();
    }
  }

  const daemon::Histogram& times() const { return times_; }
  int aborts() const { return aborts_; }
  int blocks() const { return blocks_; }
  int lost_segments() const { return lost_segments_; }
  std::uint64_t bytes() const { return bytes_; }
  bool waits_longer_than(std::int64_t ns) const {
    return asked_ns_ != 0 && now_ns() - asked_ns_ > ns;
  }

 private:
  using Bytes = std::array<std::uint8_t, 8>;
  static constexpr int first_size = 127;
  static constexpr std::int64_t frame_ns = ms / 2;
  static constexpr Bytes value_request{0x40, 0x18, 0x10, 4};
  static constexpr Bytes block_request{0xA4, 0x21, 0x10, 0, first_size, 0};

  void send(const Bytes& data) { port_.send({.id = 0x600U + node_, .length = 8, .data = data}); }
  void plan(const Bytes& data) {
    planned_ = data;
    due_ns_ = now_ns() + (frames_ + 1) * frame_ns;
    frames_ = 0;
  }
  void next() {
    ++at_;
    begin();
  }
  void receive_segment(const hal::CanFrame& frame) {
    const int number = frame.data[0] & 0x7F;
    const bool last = (frame.data[0] & 0x80U) != 0;
    if (number == segment_ + 1) {
      segment_ = number;
      bytes_ += 7;
    } else {
      ++lost_segments_;
    }
    if (number == block_size_ || last) {
      ending_ = last && number == segment_;
      const auto received = static_cast<std::uint8_t>(segment_);
      segment_ = ending_ ? -1 : 0;
      block_size_ = sizes_(random_);
      plan({0xA2, received, static_cast<std::uint8_t>(block_size_)});
    }
  }

  hal::CanSocket& port_;
  std::uint32_t node_;
  daemon::Histogram times_;
  std::mt19937 random_{7};
  std::uniform_int_distribution<int> sizes_{1, 127};
  Bytes planned_{};
  std::int64_t asked_ns_ = 0, due_ns_ = 0, frames_ = 0;
  int block_size_ = first_size;
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
    std::int64_t at_ns = now_ns() + 2 * ms;
    transferring_ = true;
    tpdos_ = 0;
    transfers_.begin();
    for (std::int64_t k = 0; k < cycles; ++k, at_ns += ms) {
      listen_until(at_ns);
      cycles_[static_cast<std::size_t>(synced_++) % cycles_.size()] = {now_ns(), target_};
      send(0x80, 0, 0);
      // Between two SYNCs: which of them shows a set-point is certain.
      listen_until(at_ns + 3 * ms / 4);
      target_ = zigzag(k);
      send(0x200 + node_, 3, 0x08'000FU);
      send(0x300 + node_, 8, static_cast<std::uint32_t>(target_));
      send(0x400 + node_, 4, 0);
      send(0x500 + node_, 4, 0);
    }
    rest(100 * ms);
    if (transfers_.waits_longer_than(1000 * ms)) {
      throw std::runtime_error("an SDO request is not answered");
    }
  }

  /// Whether all is well.
  bool report() {
    const daemon::Histogram& t = transfers_.times();
    const auto us = [](std::int64_t ns) { return static_cast<double>(ns) / 1e3; };
    const auto print = [&](const char* what, const daemon::Histogram& h) {
      fmt::print("LOAD {} {} p50 {:.0f} p99 {:.0f} p99_9 {:.0f} max {:.0f} us\n", what, h.count(),
                 us(h.quantile_ns(0.5)), us(h.quantile_ns(0.99)), us(h.quantile_ns(0.999)),
                 us(h.max_ns()));
    };
    print("answers", t);
    print("synced", delays_);
    fmt::print("LOAD sheets {} bytes {} lost_segments {} aborts {}\n", transfers_.blocks(),
               transfers_.bytes(), transfers_.lost_segments(), transfers_.aborts());
    const std::int64_t lost_tpdos = 4 * synced_ - tpdos_;
    fmt::print("LOAD setpoints {} lost {} lost_tpdos {} unread {}\n", checked_, lost_, lost_tpdos,
               port_.statistics().lost);
    fmt::print("LOAD statusword {:04X}h\n", status_);
    constexpr double max_us = 15'000, usual_us = 5000;
    return checked_ > 0 && lost_ == 0 && lost_tpdos == 0 && transfers_.aborts() == 0 &&
           transfers_.blocks() > 0 && us(t.quantile_ns(0.99)) < usual_us &&
           us(t.max_ns()) <= max_us && (status_ & 0x6FU) == 0x27;
  }

 private:
  struct Cycle {
    std::int64_t synced_ns;
    std::int32_t target_um;  ///< target of the last RPDO before the SYNC; 0: none
  };

  /// Up and down by 1 um in each cycle: no two in succession are the same.
  static std::int32_t zigzag(std::int64_t k) {
    constexpr std::int64_t min = 400, span = 40;
    const std::int64_t at = k % (2 * span);
    return static_cast<std::int32_t>(min + (at < span ? at : 2 * span - at));
  }

  void send(std::uint32_t id, std::uint8_t length, std::uint64_t value) {
    hal::CanFrame frame{.id = id, .length = length};
    put_number(frame.data, value);
    port_.send(frame);
  }
  void rest(std::int64_t ns) { listen_until(now_ns() + ns); }
  /// Does not wake for each frame: the kernel stamps them, and to change between two programs is
  /// what an emulated processor is slowest at.
  void listen_until(std::int64_t at_ns) {
    for (;;) {
      hal::CanFrame frame;
      while (port_.receive(frame)) {
        take(frame, stamp_ns(port_));
      }
      transfers_.advance();
      if (at_ns <= now_ns()) {
        return;
      }
      const std::int64_t due_ns = transfers_.due_ns();
      sleep_until(due_ns == 0 ? at_ns : std::min(at_ns, due_ns));
    }
  }
  void take(const hal::CanFrame& frame, std::int64_t came_ns) {
    if (frame.id == 0x580 + node_) {
      if (transferring_) {
        transfers_.receive(frame, came_ns);
      }
      answer_ = frame;
      answered_ = true;
    } else if (frame.id == 0x180 + node_) {
      status_ = static_cast<std::uint16_t>(take_number(std::span(frame.data).first(2)));
      ++tpdos_;
    } else if (frame.id == 0x280 + node_) {
      ++tpdos_;
      check(static_cast<std::int32_t>(take_number(std::span(frame.data).first(4))), came_ns);
    } else if (frame.id == 0x380 + node_ || frame.id == 0x480 + node_) {
      ++tpdos_;
    }
  }
  /// Each SYNC has one answer, in their order.
  void check(std::int32_t shown_um, std::int64_t came_ns) {
    const Cycle& cycle = cycles_[static_cast<std::size_t>(answered_syncs_++) % cycles_.size()];
    delays_.add(came_ns - cycle.synced_ns);
    if (cycle.target_um != 0) {
      ++checked_;
      lost_ += shown_um == cycle.target_um ? 0 : 1;
    }
  }

  std::uint32_t ask(std::uint8_t command, Key key, std::uint32_t value) {
    hal::CanFrame request{.id = 0x600 + node_, .length = 8};
    request.data = {command, static_cast<std::uint8_t>(key.index),
                    static_cast<std::uint8_t>(key.index >> 8U), key.sub};
    put_number(std::span(request.data).subspan(4), value);
    answered_ = false;
    port_.send(request);
    const std::int64_t end_ns = now_ns() + patience_ns;
    while (!answered_ && now_ns() < end_ns) {
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

  hal::CanSocket port_;
  std::uint32_t node_;
  Transfers transfers_;
  hal::CanFrame answer_{};
  bool answered_ = false, transferring_ = false;
  std::uint16_t status_ = 0;
  std::int32_t target_ = 0;
  std::array<Cycle, 1024> cycles_{};  ///< the last ones, by their number
  daemon::Histogram delays_;          ///< delays from SYNC to the second TPDO
  std::int64_t synced_ = 0, answered_syncs_ = 0, tpdos_ = 0, checked_ = 0, lost_ = 0;
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
