// The bridge as a process of its own, killed, beside the real daemon on a simulated wire.

#include <atomic>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "firmware/canopen/node/object.hpp"
#include "host-sim/can/bus/port_bus.hpp"
#include "host-sim/can/sdo_client.hpp"
#include "host-sim/page/servos/servo_source.hpp"
#include "tests/firmware/daemon/live/daemon_program.hpp"

namespace smaservo::page {
namespace {

/// Almost the servo's own, which is the longest: only a machine that does not let the bridge run
/// for so long ends the heat before the test does.
constexpr float watch_s = 4.5;

/// Tests run beside each other.
std::string own_bus() {
  return fmt::format("udp:239.74.163.4%lo:{}", 20000 + getpid() % 20000);
}

struct OneClient final : Sink {
  void message(std::uint32_t /*channel*/, std::int64_t /*time_ns*/,
               std::shared_ptr<const std::string> /*body*/) override {}
  void channels_changed() override {}
  void parameters_changed(const std::vector<NamedValue>& /*values*/) override {}
  std::vector<ClientState> clients() override { return {{1, "127.0.0.1", 0, 0, false}}; }
};

std::uint32_t service_id(Source& source, const std::string& name) {
  for (const Service& service : source.services()) {
    if (service.name == name) {
      return service.id;
    }
  }
  return 0;
}

/// Enables the servo and moves it, then only stays alive.
[[noreturn]] void be_a_bridge(const std::string& bus) {
  OneClient client;
  ServoOptions options;
  options.can = bus;
  options.watch_s = watch_s;
  const auto source = make_servo_source(options);
  source->start(client);
  source->subscribed(1001, 1);
  const auto succeeds = [&](const char* service, const char* request) {
    std::atomic<int> result = -1;
    source->call({1, false}, service_id(*source, service), request,
                 [&](const Answer& answer) { result = answer.ok ? 1 : 0; });
    while (result < 0) {
      usleep(1000);
    }
    return result == 1;
  };
  while (!succeeds("enable", R"({"node":1})")) {
    usleep(100'000);
    succeeds("reset_faults", R"({"node":1})");
  }
  succeeds("mode", R"({"node":1,"mode":1})");
  succeeds("target", R"({"node":1,"value":800})");
  for (;;) {
    pause();
  }
}

class BridgeProcess {
 public:
  explicit BridgeProcess(const std::string& bus) : pid_(fork()) {
    if (pid_ == 0) {
      be_a_bridge(bus);
    }
  }
  ~BridgeProcess() { kill(); }
  BridgeProcess(const BridgeProcess&) = delete;
  BridgeProcess& operator=(const BridgeProcess&) = delete;
  /// Afterwards it is gone.
  void kill() {
    if (pid_ <= 0) {
      return;
    }
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 private:
  pid_t pid_;
};

double real_at(can::SdoClient& servo, Key key) {
  const can::Bytes bytes = servo.upload(key);
  return static_cast<double>(
      canopen::as_real(static_cast<std::uint32_t>(canopen::take_number(bytes))));
}

// That only renewals feed the watch, and when it ends the heat, is
// PageServos.HeatEndsWithTheBridge.
TEST(PageBridge, KilledLeavesNoHeat) {
  constexpr Key measured_current{0x2200, 20}, watch{0x2002, 1};
  constexpr double heated_A = 0.02, off_A = 0.002;
  const std::string bus = own_bus();
  const test::TemporaryFolder folder;
  const std::string status = folder / "status.json";
  const test::Program daemon(folder, {"--board", "sim", "--bus", bus, "--no-real-time",
                                      "--settings", folder / "store", "--status", status});
  can::PortBus port(bus);
  can::SdoClient servo(port, 1);
  servo.set_timeout(std::chrono::microseconds(test::patience).count());
  BridgeProcess bridge(bus);
  // As long as the bridge lives its requests would meet those of a second client on the SDO
  // channel.
  const auto flows = [&] {
    const auto said = nlohmann::json::parse(test::file_text(status), nullptr, false);
    return said.is_object() && said.value("drive_current_A", 0.0) > heated_A;
  };
  ASSERT_TRUE(test::becomes(flows));
  // By PDO, or by a write of the controlword.
  const auto renews = [](const hal::CanFrame& frame) {
    return frame.id == 0x201 || (frame.id == 0x601 && frame.data[0] == 0x2B &&
                                 frame.data[1] == 0x40 && frame.data[2] == 0x60);
  };
  const auto is_renewed = [&] {
    bool seen = false;
    for (hal::CanFrame frame; port.receive(frame, 0);) {
      seen = seen || renews(frame);
    }
    return seen;
  };
  is_renewed();  // forgets what came before the heat
  const auto is_renewed_or_cold = [&] { return is_renewed() || !flows(); };
  ASSERT_TRUE(test::becomes(is_renewed_or_cold));
  ASSERT_TRUE(flows()) << "the servo's watch has ended the heat: the bridge did not run for "
                       << watch_s << " s";
  bridge.kill();
  ASSERT_GT(real_at(servo, measured_current), heated_A) << "it was killed hot";
  EXPECT_EQ(real_at(servo, watch), watch_s) << "the bridge's time, not the usual one of 5 s";
  EXPECT_TRUE(test::becomes([&] { return real_at(servo, measured_current) < off_A; }));
  daemon.kill(SIGTERM);
}

}  // namespace
}  // namespace smaservo::page
