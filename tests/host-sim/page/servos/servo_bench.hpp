#pragma once
// Servos on a bus in virtual time, a bridge on two ports of it, and its clients.

#include <deque>
#include <list>
#include <map>
#include <nlohmann/json.hpp>

#include "host-sim/page/servos/bridge.hpp"
#include "model/files/error.hpp"
#include "tests/can/simulated_servo.hpp"

namespace smaservo::test {

class ServoBus {
 public:
  struct Port;

  /// The node-ids may be equal.
  explicit ServoBus(const std::vector<unsigned>& nodes, const canopen::ServoConfig& config = {}) {
    for (const unsigned node : nodes) {
      add(node, config);
    }
  }
  SimulatedServo& add(unsigned node, const canopen::ServoConfig& config = {}) {
    Member& member = servos_.emplace_back(
        std::make_unique<SimulatedServo>(SimulatedServo::usual_settings(node), config));
    // Those that came earlier have lived longer: only this clock is read.
    return *member.servo;
  }
  std::unique_ptr<can::Bus> port();

  SimulatedServo& servo(std::size_t i) { return *std::next(servos_.begin(), long(i))->servo; }
  /// Takes it off the bus, or connects it again.
  void connect(std::size_t i, bool connected) {
    std::next(servos_.begin(), long(i))->connected = connected;
  }
  double flowing_A(std::size_t i) { return servo(i).rig().flowing_A; }
  double all_flowing_A() {
    double sum = 0;
    for (Member& member : servos_) {
      sum += std::abs(member.servo->rig().flowing_A);
    }
    return sum;
  }
  std::int64_t now_us() const { return now_us_; }
  /// Time in which nobody here runs, as on a computer that is busy with other things.
  void stand_still(double seconds) { now_us_ += std::int64_t(seconds * 1e6); }
  void run(double seconds) {
    for (const std::int64_t end_us = now_us_ + std::int64_t(seconds * 1e6); now_us_ < end_us;) {
      step();
    }
  }

  bool down = false;                                ///< the interface is down
  std::function<bool(const hal::CanFrame&)> loses;  ///< whether a frame of a servo is lost
  std::function<void()> before_receive;             ///< called before `hooked` receives
  const can::Bus* hooked = nullptr;

  struct Port final : can::Bus {
    explicit Port(ServoBus& bus_) : bus(bus_) { bus.ports_.push_back(this); }
    ~Port() override { std::erase(bus.ports_, this); }
    void send(const hal::CanFrame& frame) override {
      if (bus.down) {
        throw files::UserError("sim: the interface is down");
      }
      bus.deliver(frame, this, nullptr);
    }
    bool receive(hal::CanFrame& frame, std::int64_t until_us) override {
      if (bus.before_receive && this == bus.hooked) {
        bus.before_receive();
      }
      while (frames.empty() && bus.now_us_ < until_us) {
        bus.step();
      }
      if (frames.empty()) {
        return false;
      }
      frame = frames.front();
      frames.pop_front();
      return true;
    }
    std::int64_t now_us() const override { return bus.now_us_; }
    std::string name() const override { return "sim"; }

    ServoBus& bus;
    std::deque<hal::CanFrame> frames;
  };

 private:
  struct Member {
    explicit Member(std::unique_ptr<SimulatedServo> servo_) : servo(std::move(servo_)) {}
    std::unique_ptr<SimulatedServo> servo;
    bool connected = true;
  };

  void step() {
    now_us_ += static_cast<std::int64_t>(SimulatedServo::step_us);
    for (Member& member : servos_) {
      member.servo->step();
      collect(member);
    }
  }
  void collect(Member& from) {
    hal::CanFrame frame;
    while (from.servo->take(frame)) {
      if (from.connected && !down && !(loses && loses(frame))) {
        deliver(frame, nullptr, &from);
      }
    }
  }
  void deliver(const hal::CanFrame& frame, const Port* port, const Member* from) {
    for (Port* other : ports_) {
      if (other != port) {
        other->frames.push_back(frame);
      }
    }
    for (Member& member : servos_) {
      if (&member == from || !member.connected) {
        continue;
      }
      member.servo->receive(frame);
      collect(member);
    }
  }

  std::list<Member> servos_;
  std::vector<Port*> ports_;
  std::int64_t now_us_ = 1'000'000;
};

inline std::unique_ptr<can::Bus> ServoBus::port() {
  return std::make_unique<Port>(*this);
}

/// What the clients get.
struct Told final : page::Sink {
  void message(std::uint32_t channel, std::int64_t time_ns,
               std::shared_ptr<const std::string> json) override {
    ++counts[channel];
    last[channel] = *json;
    times_ns[channel].push_back(time_ns);
  }
  void channels_changed() override { ++channel_lists; }
  void parameters_changed(const std::vector<page::NamedValue>& values) override {
    for (const page::NamedValue& value : values) {
      parameters[value.name] = value.value;
    }
  }
  std::vector<page::ClientState> clients() override { return present; }

  nlohmann::json of(std::uint32_t channel) { return nlohmann::json::parse(last.at(channel)); }

  std::map<std::uint32_t, unsigned> counts;
  std::map<std::uint32_t, std::string> last;
  std::map<std::uint32_t, std::vector<std::int64_t>> times_ns;
  std::map<std::string, std::string> parameters;
  std::vector<page::ClientState> present;
  unsigned channel_lists = 0;
};

/// A bridge on the bus with clients 1, 2, 3 and the read-only 9.
class BridgeBench {
 public:
  explicit BridgeBench(const std::vector<unsigned>& nodes, page::BridgePlan plan = usual_plan(),
                       const canopen::ServoConfig& config = {})
      : bus(nodes, config), bridge(by_clock_of_bench(std::move(plan)), hooked_port(), bus.port()) {
    for (const unsigned client : {1U, 2U, 3U, 9U}) {
      told.present.push_back({client, "127.0.0.1", 0, 0, client == 9});
    }
    bridge.start(told);
    bridge.subscribed(1, 1);
  }
  std::unique_ptr<can::Bus> hooked_port() {
    auto port = bus.port();
    bus.hooked = port.get();
    return port;
  }
  page::BridgePlan by_clock_of_bench(page::BridgePlan plan) {
    plan.wall_ns = [this] { return wall_at_0_ns + 1000 * bus.now_us(); };
    return plan;
  }
  static page::BridgePlan usual_plan() {
    page::BridgePlan plan;
    plan.traffic.requests_per_s = 4000;
    return plan;
  }

  void run(double seconds) {
    const std::int64_t until_us = bus.now_us() + std::int64_t(seconds * 1e6);
    while (bus.now_us() < until_us) {
      bridge.round();
    }
  }
  void watch(unsigned node) {
    bridge.subscribed(1000 + node, 1);
    bridge.subscribed(2000 + node, 1);
  }

  struct Got {
    bool done = false, ok = false;
    std::string text;
    nlohmann::json json() const { return nlohmann::json::parse(text); }
  };
  std::shared_ptr<Got> ask(unsigned client, const std::string& service,
                           const std::string& request) {
    auto got = std::make_shared<Got>();
    bridge.call({client, client == 9}, id_of(service), request,
                [got](const page::Answer& answer) { *got = {true, answer.ok, answer.text}; });
    return got;
  }
  Got call(unsigned client, const std::string& service, const std::string& request = "{}",
           double patience_s = 30) {
    const auto got = ask(client, service, request);
    const std::int64_t until_us = bus.now_us() + std::int64_t(patience_s * 1e6);
    while (!got->done && bus.now_us() < until_us) {
      bridge.round();
    }
    return *got;
  }
  /// The refusal; "" where it was taken.
  std::string set(unsigned client, const std::vector<page::NamedValue>& values) {
    std::string refusal = "no answer";
    bool done = false;
    bridge.set_parameters({client, client == 9}, values,
                          [&](const std::vector<page::NamedValue>& now, const std::string& why) {
                            in_force = now;
                            refusal = why;
                            done = true;
                          });
    const std::int64_t until_us = bus.now_us() + 5'000'000;
    while (!done && bus.now_us() < until_us) {
      bridge.round();
    }
    return refusal;
  }
  std::string get(const std::string& name) {
    std::string value;
    bridge.get_parameters({name}, [&](const std::vector<page::NamedValue>& values) {
      if (!values.empty()) {
        value = values.front().value;
      }
    });
    return value;
  }
  std::uint32_t id_of(const std::string& service) {
    for (const page::Service& known : bridge.services()) {
      if (known.name == service) {
        return known.id;
      }
    }
    return 0;
  }

  ServoBus bus;
  std::int64_t wall_at_0_ns = 1'700'000'000'000'000'000;  ///< a step of it is one of the wall clock
  Told told;
  page::Bridge bridge;
  std::vector<page::NamedValue> in_force;
};

}  // namespace smaservo::test
