#include "host-sim/page/servos/servo_source.hpp"

#include <thread>

#include "host-sim/can/bus/port_bus.hpp"
#include "host-sim/page/servos/bridge.hpp"
#include "model/files/error.hpp"

namespace smaservo::page {
namespace {

/// Requests per second: 40 % of a bus at 500 kbit/s; a network of this machine has more room.
constexpr double requests_on_can = 800;
constexpr double requests_on_udp = 4000;

BridgePlan plan_of(const ServoOptions& options) {
  if (!(options.watch_s >= 0.6F && options.watch_s <= 60)) {
    throw files::UserError("--watch: must be 0.6 to 60 s");
  }
  BridgePlan plan;
  plan.operations = {options.key, options.watch_s, options.timeout_s};
  plan.traffic.requests_per_s = options.can.starts_with("udp") ? requests_on_udp : requests_on_can;
  plan.sync_s = options.sync_s;
  if (options.sync_s > 0) {
    plan.sync_signals = options.sync_signals;
  }
  plan.read_only = options.read_only;
  return plan;
}

class ServoSource final : public Source {
 public:
  explicit ServoSource(const ServoOptions& options)
      : bridge_(plan_of(options), std::make_unique<can::PortBus>(options.can),
                std::make_unique<can::PortBus>(options.can)) {}
  ~ServoSource() override { ServoSource::stop(); }
  ServoSource(const ServoSource&) = delete;
  ServoSource& operator=(const ServoSource&) = delete;

  void start(Sink& sink) override {
    bridge_.start(sink);
    thread_ = std::jthread([this](const std::stop_token& ends) {
      while (!ends.stop_requested()) {
        bridge_.round();
      }
    });
  }
  void stop() override {
    if (!thread_.joinable()) {
      return;
    }
    thread_.request_stop();
    bridge_.interrupt();
    thread_.join();
    bridge_.stop();
  }
  std::vector<Channel> channels() override { return bridge_.channels(); }
  std::vector<Service> services() override { return bridge_.services(); }
  void subscribed(std::uint32_t channel, unsigned clients) override {
    bridge_.subscribed(channel, clients);
  }
  void get_parameters(std::vector<std::string> names,
                      std::function<void(std::vector<NamedValue>)> reply) override {
    bridge_.get_parameters(std::move(names), std::move(reply));
  }
  void set_parameters(
      Caller caller, std::vector<NamedValue> values,
      std::function<void(std::vector<NamedValue>, std::string refusal)> reply) override {
    bridge_.set_parameters(caller, std::move(values), std::move(reply));
  }
  void call(Caller caller, std::uint32_t service, std::string request,
            std::function<void(Answer)> reply) override {
    bridge_.call(caller, service, std::move(request), std::move(reply));
  }
  void client_left(std::uint32_t client) override { bridge_.client_left(client); }

 private:
  Bridge bridge_;
  std::jthread thread_;
};

}  // namespace

std::unique_ptr<Source> make_servo_source(const ServoOptions& options) {
  return std::make_unique<ServoSource>(options);
}

}  // namespace smaservo::page
