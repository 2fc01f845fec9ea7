#pragma once
// A source without a bus: one servo that sends at a fixed rate, parameters with a range, services
// that answer, refuse, and wait for another one before they answer.

#include <atomic>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>
#include <utility>

#include "host-sim/page/source.hpp"

namespace smaservo::page {

class TestSource final : public Source {
 public:
  enum ChannelId : std::uint32_t { bridge = 1, live = 2, second = 3 };
  enum ServiceId : std::uint32_t {
    echo = 1,
    refuse,
    hold,
    release,  ///< answers all that is held, from a thread of its own
    big,
    second_servo,
    counts,
    end_sending
  };

  explicit TestSource(double rate_Hz) : rate_Hz_(rate_Hz) {}
  ~TestSource() override { stop(); }
  TestSource(const TestSource&) = delete;
  TestSource& operator=(const TestSource&) = delete;

  void start(Sink& sink) override {
    sink_ = &sink;
    sender_ = std::thread([this] { send(); });
  }
  void stop() override {
    ending_ = true;
    if (sender_.joinable()) {
      sender_.join();
    }
    for (std::thread& thread : releasing_) {
      if (thread.joinable()) {
        thread.join();
      }
    }
  }

  std::vector<Channel> channels() override {
    const std::string schema = R"({"type":"object"})";
    std::vector<Channel> all{{bridge, "/bridge", "smaservo.Bridge", schema},
                             {live, "/node1/live", "smaservo.Live", schema}};
    if (has_second_) {
      all.push_back({second, "/node2/live", "smaservo.Live", schema});
    }
    return all;
  }
  std::vector<Service> services() override {
    const std::string schema = R"({"type":"object"})";
    std::vector<Service> all;
    for (const char* name :
         {"echo", "refuse", "hold", "release", "big", "second_servo", "counts", "end_sending"}) {
      all.push_back({static_cast<std::uint32_t>(all.size() + 1), name, schema, schema});
    }
    return all;
  }
  void subscribed(std::uint32_t channel, unsigned clients) override { wanted_[channel] = clients; }

  void get_parameters(std::vector<std::string> names,
                      std::function<void(std::vector<NamedValue>)> reply) override {
    reply(values(names));
  }
  void set_parameters(
      Caller caller, std::vector<NamedValue> asked,
      std::function<void(std::vector<NamedValue>, std::string refusal)> reply) override {
    std::vector<std::string> names;
    std::string refusal = caller.read_only ? "the server is read-only" : "";
    for (const NamedValue& one : asked) {
      names.push_back(one.name);
      const nlohmann::json value = nlohmann::json::parse(one.value);
      if (!refusal.empty()) {
        break;
      }
      if (!parameters_.contains(one.name)) {
        refusal = one.name + ": there is no such parameter";
      } else if (!value.is_number() || !(0 <= value.get<double>() && value.get<double>() <= 100)) {
        refusal = fmt::format("{} {}: must be 0 to 100", one.name, one.value);
      }
    }
    if (!refusal.empty()) {
      reply(values(names), refusal);
      return;
    }
    for (const NamedValue& one : asked) {
      parameters_[one.name] = nlohmann::json::parse(one.value).get<double>();
    }
    const std::vector<NamedValue> now = values(names);
    reply(now, "");
    sink_->parameters_changed(now);
  }
  void call(Caller caller, std::uint32_t service, std::string request,
            std::function<void(Answer)> reply) override {
    const nlohmann::json asked = nlohmann::json::parse(request);
    if (service == echo) {
      reply({true, request});
    } else if (service == refuse) {
      reply({false, "blocked by wire_open"});
    } else if (service == hold) {
      held_.push_back(std::move(reply));
    } else if (service == release) {
      releasing_.emplace_back([held = std::exchange(held_, {})] {
        for (const auto& answer : held) {
          answer({true, R"({"held":true})"});
        }
      });
      reply({true, "{}"});
    } else if (service == big) {
      std::string text = R"({"base64":")";
      text.append(asked.value("bytes", 1000U), 'A').append(R"("})");
      reply({true, std::move(text)});
    } else if (service == second_servo) {
      has_second_ = asked.value("there", false);
      sink_->channels_changed();
      reply({true, "{}"});
    } else if (service == counts) {
      reply({true, nlohmann::json{{"client", caller.client},
                                  {"live", wanted_[live]},
                                  {"left", left_},
                                  {"sent", sent_.load()}}
                       .dump()});
    } else {
      sending_ = false;
      reply({true, "{}"});
    }
  }
  void client_left(std::uint32_t client) override { left_.insert(client); }

 private:
  std::vector<NamedValue> values(const std::vector<std::string>& names) const {
    std::vector<NamedValue> all;
    for (const auto& [name, value] : parameters_) {
      if (names.empty() || std::ranges::find(names, name) != names.end()) {
        all.push_back({name, nlohmann::json(value).dump()});
      }
    }
    return all;
  }

  static std::string sample(std::uint64_t number) {
    const double phase = static_cast<double>(number) * 1e-3;
    return fmt::format(
        R"({{"number":{},"strain":{:.6g},"setpoint":{:.6g},"drive_current_A":{:.6g},"power_W":{:.6g},)"
        R"("resistance_ohm":{:.6g},"wire_temperature_K":{:.6g},"martensite":{:.6g},"austenite":{:.6g}}})",
        number, 0.02 + 0.01 * std::sin(phase), 0.02, 0.3 + 0.1 * std::cos(phase),
        1 + std::cos(phase), 12 + std::sin(3 * phase), 340 + 20 * std::sin(phase),
        0.5 + 0.4 * std::sin(phase), 0.5 - 0.4 * std::sin(phase));
  }

  std::string state() const {
    nlohmann::json clients = nlohmann::json::array();
    for (const ClientState& one : sink_->clients()) {
      clients.push_back({{"client", one.client},
                         {"address", one.address},
                         {"queued", one.queued},
                         {"dropped", one.dropped},
                         {"read_only", one.read_only}});
    }
    return nlohmann::json{{"bus", "test"}, {"clients", clients}}.dump();
  }

  void send() {
    using Clock = std::chrono::steady_clock;
    const auto period =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_Hz_));
    auto due = Clock::now();
    auto bridge_due = due;
    while (!ending_) {
      std::this_thread::sleep_until(due += period);
      const std::int64_t now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                      std::chrono::system_clock::now().time_since_epoch())
                                      .count();
      if (sending_) {
        const std::uint64_t number = sent_++;
        sink_->message(live, now_ns, std::make_shared<std::string>(sample(number)));
      }
      if (Clock::now() >= bridge_due) {
        bridge_due += std::chrono::milliseconds(250);
        sink_->message(bridge, now_ns, std::make_shared<std::string>(state()));
      }
    }
  }

  double rate_Hz_;
  Sink* sink_ = nullptr;
  std::thread sender_;
  std::vector<std::thread> releasing_;
  std::vector<std::function<void(Answer)>> held_;
  std::atomic<bool> ending_ = false, sending_ = true;
  std::atomic<std::uint64_t> sent_ = 0;
  bool has_second_ = false;
  std::map<std::uint32_t, unsigned> wanted_;
  std::set<std::uint32_t> left_;
  std::map<std::string, double> parameters_{{"node1.limits.current_A", 4.0},
                                            {"node1.strain.integral_W_s", 20.0},
                                            {"node1.strain.proportional_W", 8.5}};
};

}  // namespace smaservo::page
