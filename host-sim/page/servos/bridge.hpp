#pragma once
// The servos of a bus as a source of channels, parameters and services, which PROTOCOL.md
// describes. The functions of Source may be called from any thread; round() runs in the bus's
// thread.

#include <deque>
#include <functional>
#include <list>
#include <nlohmann/json_fwd.hpp>
#include <set>

#include "host-sim/background.hpp"
#include "host-sim/page/servos/commissioning/commissioner.hpp"
#include "host-sim/page/servos/messages/exports.hpp"
#include "host-sim/page/servos/operations.hpp"
#include "host-sim/page/servos/traffic/off_switch.hpp"

namespace smaservo::page {

/// Time of the system's clock: nanoseconds since 1970.
std::int64_t system_wall_ns();

struct BridgePlan {
  OperationsPlan operations;
  TrafficPlan traffic;
  double sync_s = 0;  ///< period of SYNC; 0: live values are polled
  std::vector<std::string> sync_signals;
  bool read_only = false;  ///< as shown on /bridge
  /// Clock for the time stamps of messages.
  std::function<std::int64_t()> wall_ns = system_wall_ns;
};

class Bridge final : public Source, private TrafficEvents {
 public:
  /// `urgent` is a second port on the same bus, used for switching off. Throws UserError.
  Bridge(BridgePlan plan, std::unique_ptr<can::Bus> bus, std::unique_ptr<can::Bus> urgent);

  void start(Sink& sink) override;
  void stop() override;
  std::vector<Channel> channels() override;
  std::vector<Service> services() override;
  void subscribed(std::uint32_t channel, unsigned clients) override;
  void get_parameters(std::vector<std::string> names,
                      std::function<void(std::vector<NamedValue>)> reply) override;
  void set_parameters(
      Caller caller, std::vector<NamedValue> values,
      std::function<void(std::vector<NamedValue>, std::string refusal)> reply) override;
  void call(Caller caller, std::uint32_t service, std::string request,
            std::function<void(Answer)> reply) override;
  void client_left(std::uint32_t client) override;

  /// Does the next task; if there is none, waits a few milliseconds for the bus.
  void round();
  /// Interrupts the present task of the bus's thread, before stop().
  void interrupt() {
    ends_ = true;
    bus_.interrupt();
  }

  const Control& control() const { return control_; }

 private:
  using Reply = std::function<void(Answer)>;
  struct Job {
    std::string service;
    std::uint32_t client = 0;
    Control::Ticket ticket = 0;        ///< 0: the job writes nothing
    std::function<std::string()> run;  ///< returns the answer
    Reply reply;
  };
  struct Recorded {
    Recorded(can::Remote remote, can::RecordingPlan plan_, double patience_s, std::uint32_t client_,
             Reply reply_)
        : recording(remote, std::move(plan_), patience_s),
          client(client_),
          reply(std::move(reply_)) {}
    RunningRecording recording;
    std::uint32_t client;
    Reply reply;
    std::int64_t next_us = 0;
  };
  struct Activity {
    std::string service;
    unsigned node;
    std::uint32_t client;
    std::int64_t start_us, expected_us;
  };
  /// The parts of a servo that other threads may access.
  struct Shown {
    std::shared_ptr<History> history;
    std::shared_ptr<KnownParameters> parameters;
  };

  // The members of TrafficEvents.
  void sampled(Servo& servo, const Sample& sample) override;
  void state_read(Servo& servo) override;
  void came(unsigned node) override;
  void left(Servo& servo) override;
  void restarted(Servo& servo) override;
  void doubled(Servo& servo) override;
  void trouble(const std::string& text) override;
  void ticked(std::int64_t now_us) override;

  // Defined in bridge_services.cpp.
  void choose(const nlohmann::json& request, const Reply& reply);
  bool call_at_once(const Caller& caller, const std::string& service, const nlohmann::json& request,
                    const Reply& reply);
  void queue(const Caller& caller, const std::string& service, const nlohmann::json& request,
             Reply reply);
  nlohmann::json work(const std::string& service, const nlohmann::json& request, const Job& job);
  nlohmann::json work_on(Servo& servo, const std::string& service, const nlohmann::json& request,
                         const Job& job);
  nlohmann::json heat(Servo& servo, const std::string& service, const nlohmann::json& request,
                      const Job& job);
  void commission(Servo& servo, const Job& job);
  void leave_commissioned(Servo& servo);
  void fit_commissioned(Commissioner::Heated heated, const Reply& reply);
  void cancel_commission(std::uint32_t client);
  void require_free_bus() const;
  nlohmann::json history(const nlohmann::json& request);
  void begin_recording(const Caller& caller, const nlohmann::json& request, const Reply& reply);
  void write_parameters(unsigned node, const std::vector<Operations::NewValue>& values);
  static std::vector<Operations::NewValue> values_in(const nlohmann::json& request);
  std::vector<NamedValue> values_of(unsigned node, const std::vector<std::size_t>& rows);
  void tell_parameters(unsigned node, const std::vector<std::size_t>& rows);
  nlohmann::json scan();
  void stop_everything(const Reply& reply);

  NodeSet all_nodes() const;
  /// `why` goes into the log; "" if the caller of the service knows the reason.
  void switch_off(const NodeSet& nodes, std::string_view why = "");
  void watch_own_lateness(std::int64_t now_us);
  void run_next();
  void rest();
  bool run_job();
  bool check_off();
  bool look_after_servos();
  bool look_after(Servo& servo, std::int64_t now_us);
  bool look_after_stream(Servo& servo);
  bool read_recording();
  void end_trial();
  bool is_wanted(std::uint32_t channel) const;
  void apply_wishes();
  void show(const Servo& servo);
  void publish_bridge(std::int64_t now_us);
  void publish_commission(std::int64_t now_us);
  void watch_clients(std::int64_t now_us);
  std::string bridge_text(std::int64_t now_us);
  std::int64_t wall_ns(std::int64_t bus_us) const { return wall_ns_at_0_ + 1000 * bus_us; }
  void take_wall_clock(std::int64_t now_us);

  BridgePlan plan_;
  std::unique_ptr<can::Bus> port_;
  OffSwitch off_switch_;
  Control control_;
  SyncStream stream_;
  LiveTraffic traffic_;
  SharedBus bus_;
  Operations operations_;
  std::atomic<Sink*> sink_ = nullptr;
  std::atomic<std::int64_t> wall_ns_at_0_ = 0;
  std::atomic<bool> ends_ = false;      ///< stop() comes next
  std::atomic<int> activity_node_ = 0;  ///< the node of a running operation; 0: none

  // Used only by the bus's thread.
  std::list<Recorded> recorded_;
  std::optional<Activity> activity_;
  std::optional<std::pair<unsigned, std::uint32_t>> trial_;  ///< node, client
  std::map<unsigned, std::int64_t> next_try_us_;
  std::string trouble_, bridge_text_;
  std::int64_t ticked_us_ = 0;  ///< 0: not set yet
  std::int64_t trouble_us_ = 0, published_us_ = 0, wall_us_ = -10'000'000, check_us_ = 0;
  std::map<unsigned, std::int64_t> live_until_us_;
  std::int64_t commission_us_ = 0;  ///< when smaservo.Commission was sent last

  // Shared by all threads.
  KeptRecordings recordings_;
  Commissioner commissioner_;
  mutable std::mutex mutex_;
  std::deque<Job> jobs_;
  NodeSet to_check_;
  std::vector<std::pair<Reply, NodeSet>> stops_;  ///< stops whose answers wait for the check
  std::map<unsigned, Shown> shown_;
  std::map<std::uint32_t, unsigned> wanted_;  ///< number of clients for each channel
  std::set<std::uint32_t> gone_clients_;
  NodeSet all_nodes_;
  Background background_;  ///< for what takes long and needs no bus
};

}  // namespace smaservo::page
