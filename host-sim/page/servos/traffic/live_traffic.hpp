#pragma once
// The frames that the bridge sends without a client's request. It reads live values and states of
// all servos in turn, looks for new servos, repeats the command that keeps an axis enabled, and
// sends SYNC. It sends single frames and never waits for an answer.

#include <functional>
#include <map>

#include "host-sim/page/servos/servo.hpp"
#include "host-sim/page/servos/traffic/courtesy.hpp"
#include "host-sim/page/servos/traffic/duplicates.hpp"
#include "host-sim/page/servos/traffic/live_round.hpp"
#include "host-sim/page/servos/traffic/search.hpp"
#include "host-sim/page/servos/traffic/shared_bus.hpp"
#include "host-sim/page/servos/traffic/state_round.hpp"
#include "host-sim/page/servos/traffic/sync_stream.hpp"

namespace smaservo::page {

struct TrafficPlan {
  /// Requests a second, of all servos together: 800 with their answers are 40 % of a bus at
  /// 500 kbit/s.
  double requests_per_s = 800;
};

/// Events that the rest of the bridge receives.
class TrafficEvents {
 public:
  virtual ~TrafficEvents() = default;
  virtual void sampled(Servo& servo, const Sample& sample) = 0;
  /// A round of the state has been read, or something in it has changed.
  virtual void state_read(Servo& servo) = 0;
  virtual void came(unsigned node) = 0;      ///< a servo has begun to answer
  virtual void left(Servo& servo) = 0;       ///< the servo does not answer any more
  virtual void restarted(Servo& servo) = 0;  ///< the servo has reported a restart
  virtual void doubled(Servo& servo) = 0;    ///< two devices answer under its node-id
  virtual void trouble(const std::string& text) = 0;
  virtual void ticked(std::int64_t now_us) = 0;
};

class LiveTraffic final : public Traffic {
 public:
  LiveTraffic(can::Bus& bus, const TrafficPlan& plan, SyncStream& stream, Control& control,
              TrafficEvents& events);

  void heard(const hal::CanFrame& frame, std::int64_t now_us) override;
  std::int64_t tick(std::int64_t now_us) override;
  void said(const hal::CanFrame& frame, std::int64_t now_us) override;
  bool waits_for(unsigned node, std::int64_t now_us) override;

  /// Sets the nodes with which a client's transfer is in progress; nothing is requested from them.
  void set_busy(const NodeSet* busy) { busy_ = busy; }
  std::map<unsigned, Servo>& servos() { return servos_; }
  /// `live`: nodes whose live values a client wants; `anything`: a client wants something at all.
  void want(const NodeSet& live, bool anything);
  /// Reads the state of a servo at once.
  void refresh(unsigned node);
  /// Asks this node whether it is a servo.
  void probe(unsigned node) { search_.propose(node); }

 private:
  enum class Reason : std::uint8_t { state, live, renewal, probe };
  /// The traffic with one node, in which at most one request waits for its answer.
  struct Link {
    bool waits = false;
    Reason reason = Reason::probe;
    Key key{};
    std::int64_t sent_us = 0;
    unsigned silences = 0;
    StateRound state;
    LiveRound live;
    Duplicates duplicates;
    SampleRate rate;
    Courtesy courtesy;
  };

  Servo* servo_of(unsigned node);
  void ask(unsigned node, Key key, Reason reason, std::int64_t now_us,
           std::optional<std::uint16_t> value = {});
  void answered(unsigned node, const hal::CanFrame& frame, std::int64_t now_us);
  void take_state(Servo& servo, Link& link, std::uint32_t value, std::int64_t now_us);
  void take_live(Servo& servo, Link& link, std::optional<std::uint32_t> value, std::int64_t now_us);
  void sample(Servo& servo, Link& link, const Sample& sample, std::int64_t now_us);
  void renew(std::int64_t now_us);
  void poll(unsigned node, std::int64_t now_us);
  void poll_live(Servo& servo, Link& link, std::int64_t now_us);
  void look_for_silence(unsigned node, std::int64_t now_us);
  void send(std::int64_t now_us);
  bool is_busy(unsigned node) const { return busy_ != nullptr && busy_->test(node); }

  can::Bus& bus_;
  TrafficPlan plan_;
  SyncStream& stream_;
  Control& control_;
  TrafficEvents& events_;
  const NodeSet* busy_ = nullptr;
  std::map<unsigned, Servo> servos_;
  std::array<Link, 128> links_;
  NodeSet live_;
  Search search_;
  bool anything_ = false;
  double allowed_ = 0;
  std::int64_t allowed_us_ = 0, pause_until_us_ = 0;
  unsigned turn_ = 0;
};

}  // namespace smaservo::page
