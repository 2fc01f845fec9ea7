#pragma once
// A bridge with one servo, whose live values and state somebody looks at.

#include <gmock/gmock.h>

#include "tests/host-sim/page/servos/servo_bench.hpp"

namespace smaservo::page {

using nlohmann::json;
using test::BridgeBench;
using testing::HasSubstr;

/// A current that warms: the least that a running device gives is below that.
inline constexpr double some_A = 0.02;

struct PageServos : testing::Test {
  static constexpr unsigned node = 5;

  BridgeBench bench{{node}};

  PageServos() {
    bench.watch(node);
    bench.run(1);
  }
  json state() { return bench.told.of(2000 + node); }
  json bridge() { return bench.told.of(1); }
  double flowing_A() { return bench.bus.flowing_A(0); }
  void heat(unsigned client) {
    ASSERT_EQ(bench.call(client, "enable", R"({"node":5})").text, "{}");
    ASSERT_EQ(bench.call(client, "mode", R"({"node":5,"mode":1})").text, "{}");
    ASSERT_EQ(bench.call(client, "target", R"({"node":5,"value":800})").text, "{}");
    bench.run(0.1);
    ASSERT_GT(flowing_A(), some_A);
  }
  can::Bytes read(Key key) {
    const auto port = bench.bus.port();
    can::SdoClient client(*port, node);
    return client.upload(key);
  }
  float watch_s() {
    return canopen::as_real(static_cast<std::uint32_t>(canopen::take_number(read({0x2002, 1}))));
  }
};

}  // namespace smaservo::page
