// Commissioning with a client as the person: in virtual time, so that a whole run takes a second of
// a processor and each of the others less. The fit is real: two seconds more.

#include <chrono>
#include <thread>

#include "firmware/parameters/parameters.hpp"
#include "model/files/wire/wire_file.hpp"
#include "tests/host-sim/page/base64.hpp"
#include "tests/host-sim/page/servos/page_servos.hpp"

namespace smaservo::page {
namespace {

using test::from_base64;
using testing::AllOf;
using testing::ElementsAre;
using testing::SizeIs;
using Got = BridgeBench::Got;

constexpr std::uint32_t commission_channel = 2;
constexpr const char* usual_run = R"({"node":5,"readings":2,"reading_sd_m":0.0001})";

struct PageCommission : PageServos {
  PageCommission() {
    bench.bridge.subscribed(commission_channel, 1);
    bench.run(1.1);
  }
  ~PageCommission() override { bench.bus.before_receive = {}; }

  json said() { return bench.told.of(commission_channel); }
  bool asks() {
    return bench.told.last.contains(commission_channel) && said()["stage"] == "asking";
  }
  double now_s() const { return 1e-6 * static_cast<double>(bench.bus.now_us()); }

  /// As a caliper reads it, whose zero is anywhere.
  std::string true_reading() {
    Rig& rig = bench.bus.servo(0).rig();
    const double strain = rig.wire->strain();
    zero_strain = zero_strain.value_or(strain);
    return fmt::format(R"({{"reading":"{:.2f}"}})",
                       1.5 + 1e3 * rig.settings.wire.geometry.length_m * (*zero_strain - strain));
  }
  /// Answers each question by the next of these; "true": by what is so.
  void answer_by(std::deque<std::string> answers) {
    bench.bus.before_receive = [this, answers = std::move(answers),
                                given = std::shared_ptr<Got>()]() mutable {
      if (given && given->done) {
        replies.push_back(*given);
        given.reset();
        told_s = now_s() + 0.3;  // the next message
      }
      if (given || now_s() < told_s || answers.empty() || !asks()) {
        return;
      }
      given = bench.ask(1, "commission_answer",
                        answers.front() == "true" ? true_reading() : answers.front());
      answers.pop_front();
    };
  }
  /// Does it once, this time after the run was asked for.
  void after(double seconds, std::function<void()> act) {
    bench.bus.before_receive = [this, at_s = now_s() + seconds, act = std::move(act)]() mutable {
      if (act && now_s() >= at_s) {
        std::exchange(act, {})();
      }
    };
  }
  /// The fit takes its time of the clock, not of the bench.
  void wait_for(const std::shared_ptr<Got>& got) {
    for (int i = 0; i < 6000 && !got->done; ++i) {
      bench.run(0.01);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(got->done);
    bench.run(0.5);
  }
  std::string file(const char* as) {
    const Got got = bench.call(2, "commission_file", fmt::format(R"({{"as":"{}"}})", as));
    return got.ok ? from_base64(got.json()["base64"]) : "";
  }
  /// Ended by somebody in the middle of the heat.
  void expect_put_back(const std::shared_ptr<Got>& got) {
    EXPECT_TRUE(got->done);
    EXPECT_FALSE(got->ok);
    bench.bus.before_receive = {};
    bench.run(1);
    EXPECT_EQ(flowing_A(), 0);
    EXPECT_EQ(canopen::take_number(read({0x6060, 0})), 0U) << "the mode is as before";
    EXPECT_EQ(canopen::take_number(read({0x2201, 2})), 0U) << "the set-point is as before";
    EXPECT_EQ(canopen::take_number(read({0x6041, 0})) & 0x6FU, 0x40U);
    EXPECT_EQ(watch_s(), 5);
    EXPECT_EQ(said()["stage"], "failed");
    EXPECT_EQ(said()["error"], got->text);
    EXPECT_EQ(said()["files"], json::array());
  }

  std::optional<double> zero_strain;  ///< of the cold wire
  std::vector<Got> replies;           ///< to the answers
  double told_s = 0;
};

TEST_F(PageCommission, AWireFileIsMadeFromTheReadingsOfAClient) {
  answer_by({R"({"reading":"1,5"})", R"({"reading":"5.o"})", R"({"reading":"77"})", "true", "{}"});
  true_reading();
  const auto got = bench.ask(1, "commission", usual_run);
  wait_for(got);
  ASSERT_TRUE(got->ok) << got->text;
  ASSERT_THAT(replies, SizeIs(5));
  EXPECT_TRUE(replies[0].ok);
  EXPECT_THAT(replies[1].text, HasSubstr("'5.o' is no length in mm"));
  EXPECT_THAT(replies[2].text, HasSubstr("a wire of 100 mm moves by at most"));
  EXPECT_TRUE(replies[3].ok);
  EXPECT_TRUE(replies[4].ok) << "skipped: " << replies[4].text;

  const json message = said();
  EXPECT_EQ(message["stage"], "done");
  EXPECT_EQ(message["node"], 5);
  EXPECT_EQ(message["client"], 1);
  EXPECT_EQ(message["left_s"], nullptr);
  EXPECT_EQ(message["files"], json({"wire", "run", "readings"}));
  const json& result = message["result"];
  EXPECT_THAT(result["text"], AllOf(HasSubstr("commission-node5.csv and 2 readings"),
                                    HasSubstr("expected mean error, % of the stroke")));
  const json& numbers = result["numbers"];
  EXPECT_EQ(numbers["anchors"].size(), 2);
  const json& error = numbers["expected_error_of_stroke"];
  EXPECT_LT(error["after"]["stroke"], error["before"]["stroke"]);

  // The files are what the command writes.
  EXPECT_THAT(file("run"), HasSubstr("time_s,current_A,voltage_V,stress_Pa"));
  EXPECT_THAT(file("readings"), HasSubstr("time_s,displacement_m,sd_m\n0.000000,0,"));
  const files::WireDescription wire = files::parse_wire(file("wire"), "wire.toml");
  EXPECT_DOUBLE_EQ(wire.wire.geometry.length_m,
                   bench.bus.servo(0).servo().settings().wire.geometry.length_m);

  // Whoever leads writes what differs, in the usual way.
  std::vector<NamedValue> values;
  for (const json& one : result["differences"]) {
    EXPECT_THAT(one["name"], testing::StartsWith("wire."));
    values.push_back({"node5." + one["name"].get<std::string>(), one["file"].dump()});
  }
  EXPECT_GT(values.size(), 5U);
  EXPECT_EQ(bench.set(1, values), "");
  EXPECT_FLOAT_EQ(
      static_cast<float>(bench.bus.servo(0).servo().settings().wire.material.martensite.strain),
      static_cast<float>(wire.wire.material.martensite.strain));
  EXPECT_EQ(flowing_A(), 0);
  EXPECT_EQ(watch_s(), 5);
}

TEST_F(PageCommission, WithoutReadingsNothingIsAsked) {
  const auto got = bench.ask(1, "commission", R"({"node":5,"readings":0})");
  wait_for(got);
  ASSERT_TRUE(got->ok) << got->text;
  EXPECT_EQ(said()["files"], json({"wire", "run"}));
  EXPECT_EQ(state()["unsaved"], false) << "no parameter was changed";
  EXPECT_THAT(bench.call(1, "commission_file", R"({"as":"readings"})").text, HasSubstr("has none"));
}

TEST_F(PageCommission, ASingleReadingIsNotUsed) {
  answer_by({R"({"reading":"1.5"})", "{}", "{}"});
  const auto got = bench.ask(1, "commission", usual_run);
  wait_for(got);
  ASSERT_TRUE(got->ok) << got->text;
  EXPECT_THAT(said()["result"]["notes"].dump(), HasSubstr("a single reading tells nothing"));
}

/// One of several benches of a test.
class PageCommissionAgain final : public PageCommission {
  void TestBody() override {}

 public:
  /// `slow`: it is found within a quarter of a second.
  void ends_by(const std::function<void(PageCommission&)>& act, const char* error, double at_s,
               bool slow) {
    after(at_s, [&] {
      acted_s = now_s();
      act(*this);
    });
    const auto arm = std::exchange(bench.bus.before_receive, {});
    bench.bus.before_receive = [this, arm, slow] {
      arm();
      if (acted_s > 0 && now_s() > acted_s + (slow ? 0.3 : 0.003)) {
        ASSERT_EQ(flowing_A(), 0);
      }
    };
    const auto got = bench.ask(1, "commission", R"({"node":5,"readings":0,"pace":0.25})");
    bench.run(at_s + 2);
    ASSERT_GT(acted_s, 0);
    ASSERT_TRUE(got->done);
    EXPECT_THAT(got->text, HasSubstr(error));
    expect_put_back(got);
  }

 private:
  double acted_s = 0;
};

// Whatever ends it, in the cold, in the rest or in the heat: no current flows 3 ms later, and the
// servo is as before.
TEST_F(PageCommission, TheHeatEndsWithWhoeverLeads) {
  struct Case {
    const char* name;
    std::function<void(PageCommission&)> act;
    const char* error = "switched off";
  };
  const Case cases[] = {
      {"cancel",
       [](PageCommission& t) { EXPECT_EQ(t.bench.ask(1, "commission_cancel", "{}")->text, "{}"); }},
      {"stop", [](PageCommission& t) { t.bench.ask(9, "stop", "{}"); }},
      {"disable", [](PageCommission& t) { t.bench.ask(1, "disable", R"({"node":5})"); }},
      {"gone", [](PageCommission& t) { t.bench.bridge.client_left(1); }},
      {"silent",
       [](PageCommission& t) {
         std::erase_if(t.bench.told.present,
                       [](const ClientState& one) { return one.client == 1; });
       }},
      {"taken", [](PageCommission& t) { t.bench.ask(2, "take_control", "{}"); }},
      {"released", [](PageCommission& t) { t.bench.ask(1, "release_control", "{}"); }},
      {"ends", [](PageCommission& t) { t.bench.bridge.interrupt(); }},
  };
  for (const Case& c : cases) {
    for (const double at_s : {0.4, 1.6, 4.0, 7.7}) {
      SCOPED_TRACE(fmt::format("{} at {} s", c.name, at_s));
      PageCommissionAgain other;
      other.ends_by(c.act, c.error, at_s, c.name == std::string_view("silent"));
    }
  }
}

// As every axis that a client has enabled.
TEST_F(PageCommission, TheServoEndsTheHeatOfABridgeThatHangs) {
  after(7.7, [&] {
    EXPECT_GT(flowing_A(), some_A);
    bench.bus.run(0.7);
    EXPECT_GT(flowing_A(), some_A) << "renewed until then";
    bench.bus.run(0.4);
    EXPECT_EQ(flowing_A(), 0);
  });
  const auto got = bench.ask(1, "commission", R"({"node":5,"readings":0,"pace":0.25})");
  bench.run(12);
  EXPECT_TRUE(got->done);
  EXPECT_THAT(got->text, HasSubstr("bus_lost"));
  EXPECT_EQ(said()["error"], got->text);
  EXPECT_EQ(watch_s(), 5);
}

TEST_F(PageCommission, TheReasonIsTheTextOfTheCore) {
  EXPECT_THAT(bench.call(1, "commission", R"({"node":7})").text, HasSubstr("there are: 5"));
  bench.run(0.1);
  EXPECT_EQ(said()["stage"], "failed");
  EXPECT_EQ(said()["node"], 7);
  // Another length than that of the settings.
  bench.bus.servo(0).rig().wire = std::make_unique<LumpedRigWire>(
      bench.bus.servo(0).rig().settings.wire, Unlike{.resistance = 0.85}, 150e6);
  const std::string why =
      bench.call(1, "commission", R"({"node":5,"readings":0,"pace":0.25})").text;
  EXPECT_THAT(why, AllOf(HasSubstr("wire.length of 85 to 86 mm"), HasSubstr("the heat is off")));
  bench.run(1);
  EXPECT_EQ(said()["error"], why);
  EXPECT_EQ(flowing_A(), 0);
}

TEST_F(PageCommission, AServoInUseIsRefusedAndLeftAlone) {
  heat(1);
  EXPECT_THAT(bench.call(1, "commission", usual_run).text, HasSubstr("node 5 is enabled"));
  bench.run(0.5);
  EXPECT_GT(flowing_A(), some_A);
  bench.call(1, "disable", R"({"node":5})");
  // By another master.
  const auto port = bench.bus.port();
  can::Remote other({*port, node});
  other.enable();
  EXPECT_THAT(bench.call(1, "commission", usual_run).text,
              HasSubstr("\"Operation enabled\" already"));
  bench.run(0.5);
  EXPECT_EQ(other.whole("6041") & 0x6FU, 0x27U) << "it is left as it was";
  EXPECT_EQ(watch_s(), 5);
  other.disable();
  // By RPDOs of another master.
  other.set("1016:1", std::to_string(7U << 16U | 500U));
  EXPECT_THAT(bench.call(1, "commission", usual_run).text, HasSubstr("obeys another master"));
}

TEST_F(PageCommission, OthersMaySeeItAndNotLeadIt) {
  std::shared_ptr<Got> answer, cancel, second, dump, written;
  std::string refusal;
  std::size_t seen = 0;
  double left_s = 0;
  after(8, [&] {
    ASSERT_TRUE(asks()) << said();
    left_s = said()["left_s"];
    answer = bench.ask(2, "commission_answer", R"({"reading":"3"})");
    cancel = bench.ask(2, "commission_cancel", "{}");
    second = bench.ask(1, "commission", usual_run);
    dump = bench.ask(2, "dump", R"({"node":5,"as":"toml"})");
    bench.bridge.set_parameters(
        {1, false}, {{"node5.strain.proportional_W", "2"}},
        [&](const std::vector<NamedValue>&, const std::string& why) { refusal = why; });
    seen = bench.told.counts[1000 + node];
    bench.bridge.client_left(1);
  });
  const auto got = bench.ask(1, "commission", usual_run);
  bench.run(10);
  expect_put_back(got);
  EXPECT_GT(left_s, 280);
  EXPECT_LT(left_s, 300);
  EXPECT_THAT(answer->text, HasSubstr("client 1 leads this run"));
  EXPECT_THAT(cancel->text, HasSubstr("client 1 leads this run"));
  EXPECT_THAT(second->text, HasSubstr("node 5 is being commissioned"));
  EXPECT_THAT(dump->text, HasSubstr("node 5 is being commissioned"));
  EXPECT_THAT(refusal, HasSubstr("node 5 is being commissioned"));
  EXPECT_GT(seen, 300U) << "its live values go on";
  EXPECT_TRUE(bench.call(2, "dump", R"({"node":5,"as":"toml"})").ok) << "the bus is free again";
}

TEST_F(PageCommission, BadRequestsChangeNothing) {
  const auto refused = [&](unsigned client, const char* service, const std::string& bad) {
    const Got got = bench.call(client, service, bad);
    EXPECT_TRUE(got.done && !got.ok) << service << bad << got.text;
    EXPECT_FALSE(asks());
    return got.text;
  };
  EXPECT_THAT(refused(9, "commission", usual_run), HasSubstr("read-only"));
  EXPECT_THAT(refused(1, "commission", "{}"), HasSubstr("node is missing"));
  EXPECT_THAT(refused(1, "commission", R"({"node":5,"readings":5})"), HasSubstr("from 0 to 4"));
  EXPECT_THAT(refused(1, "commission", R"({"node":5,"readings":1.5})"), HasSubstr("whole"));
  EXPECT_THAT(refused(1, "commission", R"({"node":5,"readings":"1"})"), HasSubstr("a number"));
  EXPECT_THAT(refused(1, "commission", R"({"node":5,"reading_sd_m":0})"),
              HasSubstr("reading_sd_m"));
  EXPECT_THAT(refused(1, "commission", R"({"node":5,"pace":0.01})"), HasSubstr("from 0.05 to 2"));
  EXPECT_THAT(refused(1, "commission_answer", "{}"), HasSubstr("no reading is asked for"));
  EXPECT_THAT(refused(1, "commission_answer", R"({"reading":3.4})"), HasSubstr("a string"));
  EXPECT_THAT(refused(1, "commission_answer", R"({"reading":" "})"), HasSubstr("in mm"));
  EXPECT_THAT(
      refused(1, "commission_answer", fmt::format(R"({{"reading":"{}"}})", std::string(200, '1'))),
      HasSubstr("at most 40 characters"));
  EXPECT_THAT(refused(1, "commission_cancel", "{}"), HasSubstr("no wire is being commissioned"));
  EXPECT_THAT(refused(1, "commission_file", R"({"as":"exe"})"), HasSubstr("must be wire, run or"));
  EXPECT_THAT(refused(1, "commission_file", R"({"as":"wire"})"), HasSubstr("there was no run"));
  EXPECT_EQ(said()["stage"], "none");
  EXPECT_EQ(flowing_A(), 0);
}

}  // namespace
}  // namespace smaservo::page
