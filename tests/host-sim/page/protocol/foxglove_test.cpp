#include "host-sim/page/protocol/foxglove.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <random>

namespace smaservo::page {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::vector<Channel> three_channels{
    {1, "/bridge", "B", "{}"}, {2, "/node1/live", "L", "{}"}, {7, "/node1/state", "S", "{}"}};
const std::vector<Service> two_services{{1, "enable", "{}", "{}"}, {2, "stop", "{}", "{}"}};

/// What a conversation has asked for.
class TestDesk final : public Desk {
 public:
  void send(Frame frame) override { frames.push_back(std::move(frame)); }
  void subscribe(std::uint32_t channel, bool is_wanted) override {
    EXPECT_NE(wanted.contains(channel), is_wanted) << "told twice of channel " << channel;
    is_wanted ? (void)wanted.insert(channel) : (void)wanted.erase(channel);
  }
  void get_parameters(std::vector<std::string> names, std::optional<std::string> id) override {
    asked.push_back(fmt::format("get {} {}", fmt::join(names, ","), id.value_or("-")));
  }
  void set_parameters(std::vector<NamedValue> values, std::optional<std::string> id) override {
    std::string all = "set";
    for (const NamedValue& one : values) {
      all += " " + one.name + "=" + one.value;
    }
    asked.push_back(all + " " + id.value_or("-"));
  }
  void call(std::uint32_t service, std::uint32_t call, std::string request) override {
    asked.push_back(fmt::format("call {} {} {}", service, call, request));
  }

  std::vector<Frame> frames;
  std::set<std::uint32_t> wanted;
  std::vector<std::string> asked;
};

class Talk : public testing::Test {
 protected:
  Talk() {
    talk.greet({.version = "1", .session = "s", .client = 3, .read_only = false, .units = "si"},
               three_channels);
    greeting = take();
  }

  std::vector<Frame> take() { return std::exchange(desk.frames, {}); }
  /// The only frame, which is a text.
  json only() {
    const std::vector<Frame> frames = take();
    if (frames.size() != 1 || frames[0].binary || frames[0].live) {
      ADD_FAILURE() << frames.size() << " frames";
      return json::object();
    }
    return json::parse(frames[0].head);
  }
  void hear(const json& message) { talk.hear_text(message.dump()); }
  void subscribe(std::uint32_t id, std::uint32_t channel) {
    hear({{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}});
  }

  TestDesk desk;
  Conversation talk{desk, two_services};
  std::vector<Frame> greeting;
};

std::string bytes_of(const Frame& frame) {
  return frame.head + (frame.body ? *frame.body : "");
}

/// A request of a service as a client writes it.
std::string request(std::uint32_t service, std::uint32_t call, std::string_view encoding,
                    std::string_view payload) {
  std::string bytes("\x02");
  for (const std::uint32_t number : {service, call, static_cast<std::uint32_t>(encoding.size())}) {
    for (unsigned shift = 0; shift < 32; shift += 8) {
      bytes.push_back(static_cast<char>(number >> shift & 0xFFU));
    }
  }
  return bytes.append(encoding).append(payload);
}

TEST_F(Talk, BeginsWithServerChannelsAndServices) {
  ASSERT_EQ(greeting.size(), 3U);
  const json info = json::parse(greeting[0].head);
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["capabilities"], json({"parameters", "parametersSubscribe", "services"}));
  EXPECT_EQ(info["supportedEncodings"], json({"json"}));
  EXPECT_EQ(info["metadata"],
            json({{"version", "1"}, {"client", "3"}, {"read_only", "false"}, {"units", "si"}}));
  const json channels = json::parse(greeting[1].head);
  EXPECT_EQ(channels["op"], "advertise");
  EXPECT_EQ(channels["channels"][2], json({{"id", 7},
                                           {"topic", "/node1/state"},
                                           {"encoding", "json"},
                                           {"schemaName", "S"},
                                           {"schema", "{}"},
                                           {"schemaEncoding", "jsonschema"}}));
  EXPECT_EQ(json::parse(greeting[2].head)["services"][1]["name"], "stop");
}

TEST_F(Talk, MessagesHaveTheLayoutOfTheProtocol) {
  subscribe(0x01020304, 2);
  talk.message(2, 0x1122334455667788, std::make_shared<std::string>(R"({"a":1})"));
  talk.message(1, 5, std::make_shared<std::string>("{}"));
  const std::vector<Frame> frames = take();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(frames[0].binary && frames[0].live);
  EXPECT_EQ(bytes_of(frames[0]),
            std::string("\x01\x04\x03\x02\x01\x88\x77\x66\x55\x44\x33\x22\x11{\"a\":1}"));
}

TEST_F(Talk, AnswersHaveTheLayoutOfTheProtocol) {
  talk.hear_bytes(request(2, 0x0A0B0C0D, "json", R"( {"b" : 2} )"));
  EXPECT_THAT(desk.asked, ElementsAre(R"(call 2 168496141 {"b":2})"));
  talk.answer(2, 0x0A0B0C0D, {.ok = true, .text = "{}"});
  const std::vector<Frame> frames = take();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(frames[0].binary && !frames[0].live);
  using namespace std::string_literals;
  EXPECT_EQ(bytes_of(frames[0]), "\x03\x02\0\0\0\x0D\x0C\x0B\x0A\x04\0\0\0json{}"s);
  talk.hear_bytes(request(2, 5, "json", "{}"));
  talk.answer(2, 5, {.ok = false, .text = "blocked"});
  EXPECT_EQ(
      only(),
      json(
          {{"op", "serviceCallFailure"}, {"serviceId", 2}, {"callId", 5}, {"message", "blocked"}}));
}

TEST_F(Talk, MalformedTextsAreAnsweredAndChangeNothing) {
  subscribe(4, 2);
  const std::string deep = std::string(200, '[') + std::string(200, ']');
  const std::pair<std::string, const char*> wrong[] = {
      {"", "no JSON"},
      {"{", "no JSON"},
      {"[]", "not a JSON object"},
      {"7", "not a JSON object"},
      {"null", "not a JSON object"},
      {"{}", "op: a text is missing"},
      {R"({"op":7})", "op: a text is missing"},
      {R"({"op":"jump"})", "jump: no such operation"},
      {R"({"op":"advertise","channels":[]})", "is not offered"},
      {R"({"op":"fetchAsset"})", "is not offered"},
      {R"({"op":"\u001b[2J"})", "x1B[2J: no such operation"},
      {"{\"op\":\"\xff\"}", "no JSON"},
      {R"({"op":"subscribe","x":)" + deep + "}", "nested deeper than 32"},
      {R"({"op":"subscribe","x":)" + std::string(limits::message_bytes, ' ') + "1}", "longer than"},
      {R"({"op":"subscribe"})", "subscriptions: an array is missing"},
      {R"({"op":"subscribe","subscriptions":{}})", "subscriptions: an array is missing"},
      {R"({"op":"subscribe","subscriptions":[7]})", "id: a whole number"},
      {R"({"op":"subscribe","subscriptions":[{"id":1}]})", "channelId: a whole number"},
      {R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})", "id: a whole number"},
      {R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})", "id: a whole number"},
      {R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})", "id: a whole"},
      {R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1},{"id":2}]})", "channelId:"},
      {R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":9}]})",
       "channel 9 does not exist"},
      {R"({"op":"subscribe","subscriptions":[{"id":4,"channelId":1}]})",
       "subscription 4 is in use"},
      {R"({"op":"subscribe","subscriptions":[{"id":5,"channelId":2}]})", "2 is subscribed already"},
      {R"({"op":"unsubscribe"})", "subscriptionIds: an array is missing"},
      {R"({"op":"unsubscribe","subscriptionIds":["4"]})", "subscriptionIds: a whole number"},
      {R"({"op":"unsubscribe","subscriptionIds":[8,9,10]})", "no subscription 8; and 2 more"},
      {R"({"op":"getParameters"})", "parameterNames: an array is missing"},
      {R"({"op":"getParameters","parameterNames":[1]})", "parameterNames: not a text"},
      {R"({"op":"getParameters","parameterNames":[],"id":1})", "id: a text is missing"},
      {R"({"op":"setParameters"})", "parameters: an array is missing"},
      {R"({"op":"setParameters","parameters":[{"value":1}]})", "name: a text is missing"},
      {R"({"op":"setParameters","parameters":[{"name":"a"}]})", "a: has no value"},
      {R"({"op":"setParameters","parameters":[{"name":"a","value":null}]})", "a: has no value"},
      {R"({"op":"setParameters","parameters":[{"name":"a","value":1},{"name":"a","value":2}]})",
       "a: stands there twice"},
      {R"({"op":"subscribeParameterUpdates","parameterNames":"a"})", "an array is missing"},
  };
  for (const auto& [text, why] : wrong) {
    talk.hear_text(text);
    const json status = only();
    EXPECT_EQ(status["op"], "status") << text.substr(0, 80);
    EXPECT_EQ(status["level"], 2);
    EXPECT_THAT(status["message"].get<std::string>(), HasSubstr(why)) << text.substr(0, 80);
    EXPECT_LT(status["message"].get<std::string>().size(), 400U);
  }
  EXPECT_THAT(desk.wanted, ElementsAre(2));
  EXPECT_THAT(desk.asked, IsEmpty());
  talk.parameters_changed(std::vector<NamedValue>{{"a", "1"}});
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(Talk, MalformedBytesAreAnsweredAndChangeNothing) {
  using namespace std::string_literals;
  const std::string no_call = "status";
  const std::string no_service = "serviceCallFailure";
  const struct {
    std::string bytes, op;
    const char* why;
  } wrong[] = {
      {"", no_call, "no such binary operation: 0"},
      {"\x09xyz", no_call, "no such binary operation: 9"},
      {"\x01\0\0\0\0{}"s, no_call, "messages of clients are not taken"},
      {"\x02", no_call, "13 to"},
      {request(1, 1, "json", "{}").substr(0, 12), no_call, "13 to"},
      {request(1, 1, "json", std::string(limits::message_bytes, ' ')), no_call, "13 to"},
      {request(9, 1, "json", "{}"), no_service, "there is no service 9"},
      {request(1, 1, "cbor", "{}"), no_service, "encoding of a request must be json"},
      {request(1, 1, "", "{}"), no_service, "encoding of a request must be json"},
      {"\x02\x01\0\0\0\x01\0\0\0\xFF\xFF\xFF\xFFjson{}"s, no_service, "must be json"},
      {request(1, 1, "json", ""), no_service, "no JSON"},
      {request(1, 1, "json", "[]"), no_service, "not a JSON object"},
      {request(1, 1, "json", "{\"\xC3\":1}"), no_service, "no JSON"},
      {request(1, 1, "json", "{}{}"), no_service, "no JSON"},
      {request(1, 1, "json", R"({"a":)" + std::string(40, '[') + std::string(40, ']') + "}"),
       no_service, "nested deeper"},
  };
  for (const auto& one : wrong) {
    talk.hear_bytes(one.bytes);
    const json said = only();
    EXPECT_EQ(said["op"], one.op);
    EXPECT_THAT(said["message"].get<std::string>(), HasSubstr(one.why));
  }
  EXPECT_THAT(desk.asked, IsEmpty());
}

TEST_F(Talk, ParametersGoBothWays) {
  hear({{"op", "getParameters"}, {"parameterNames", {"a", "b"}}, {"id", "x"}});
  hear({{"op", "getParameters"}, {"parameterNames", json::array()}});
  hear({{"op", "setParameters"},
        {"parameters", {{{"name", "a"}, {"value", 1.5}}, {{"name", "b"}, {"value", "on"}}}},
        {"id", "y"}});
  EXPECT_THAT(desk.asked, ElementsAre("get a,b x", "get  -", R"(set a=1.5 b="on" y)"));
  EXPECT_THAT(take(), IsEmpty());
  const std::vector<NamedValue> values{
      {"a", "4.0"}, {"b", "\"on\""}, {"c", "3"}, {"d", "true"}, {"e", "null"}};
  talk.parameter_values(values, "x", "");
  EXPECT_EQ(only(), json({{"op", "parameterValues"},
                          {"id", "x"},
                          {"parameters",
                           {{{"name", "a"}, {"value", 4.0}, {"type", "float64"}},
                            {{"name", "b"}, {"value", "on"}},
                            {{"name", "c"}, {"value", 3}},
                            {{"name", "d"}, {"value", true}},
                            {{"name", "e"}, {"value", nullptr}}}}}));
  talk.parameter_values(std::span(values).first(1), "y", "a: 99 must be 0 to 20");
  const std::vector<Frame> frames = take();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(json::parse(frames[0].head)["id"], "y");
  EXPECT_EQ(json::parse(frames[1].head),
            json({{"op", "status"}, {"level", 2}, {"message", "a: 99 must be 0 to 20"}}));
}

TEST_F(Talk, OpenRequestsAreBounded) {
  for (std::uint32_t i = 0; i < limits::calls; ++i) {
    talk.hear_bytes(request(1, i, "json", "{}"));
  }
  EXPECT_THAT(take(), IsEmpty());
  talk.hear_bytes(request(1, 100, "json", "{}"));
  EXPECT_EQ(only()["callId"], 100);
  hear({{"op", "getParameters"}, {"parameterNames", json::array()}});
  EXPECT_THAT(only()["message"].get<std::string>(), HasSubstr("not answered yet"));
  EXPECT_EQ(desk.asked.size(), limits::calls);
  talk.answer(1, 0, {.ok = true, .text = "{}"});
  talk.hear_bytes(request(1, 101, "json", "{}"));
  EXPECT_EQ(desk.asked.size(), limits::calls + 1);
}

// Random subscriptions, messages and servos that come and go, against a model of two maps.
class TalkAndModel : public Talk {
 protected:
  TalkAndModel() {
    for (const Channel& one : three_channels) {
      there[one.id] = one;
    }
  }

  std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); }

  bool has(std::uint32_t channel) const {
    return std::ranges::any_of(channel_of, [&](auto& one) { return one.second == channel; });
  }

  void a_subscription(std::uint32_t id, std::uint32_t channel) {
    subscribe(id, channel);
    const bool fine = there.contains(channel) && !channel_of.contains(id) && !has(channel);
    if (fine) {
      channel_of[id] = channel;
    }
    EXPECT_EQ(take().size(), fine ? 0U : 1U);
  }

  void an_end(std::uint32_t id) {
    hear({{"op", "unsubscribe"}, {"subscriptionIds", {id}}});
    EXPECT_EQ(take().size(), 1 - channel_of.erase(id));
  }

  /// One comes, goes, or is another one under the same number.
  void another_channel(std::uint32_t channel) {
    std::map<std::uint32_t, Channel> now = there;
    if (now.erase(channel) == 0 || below(3) == 0) {
      now[channel] = {channel, fmt::format("/{}", below(3)), "T", "{}"};
    }
    const bool had = there.contains(channel), has_now = now.contains(channel);
    const bool changed = had && has_now && there[channel].topic != now[channel].topic;
    const bool goes = (had && !has_now) || changed, comes = (!had && has_now) || changed;
    if (goes) {
      std::erase_if(channel_of, [&](auto& one) { return one.second == channel; });
      desk.wanted.erase(channel);  // it has ended without a word
    }
    there = now;
    show_channels();
    std::vector<std::string> expected;
    if (goes) {
      expected.emplace_back("unadvertise");
    }
    if (comes) {
      expected.emplace_back("advertise");
    }
    EXPECT_EQ(taken_ops(), expected);
  }

  void a_message(std::uint32_t channel, int time) {
    talk.message(channel, time, std::make_shared<std::string>("{}"));
    const std::vector<Frame> frames = take();
    ASSERT_EQ(frames.size(), has(channel) ? 1U : 0U);
    if (!frames.empty()) {
      EXPECT_EQ(channel_of.at(static_cast<std::uint32_t>(frames[0].head[1])), channel);
    }
  }

  void be_the_same() const {
    std::set<std::uint32_t> wanted;
    for (const auto& [number, one] : channel_of) {
      wanted.insert(one);
    }
    ASSERT_EQ(desk.wanted, wanted);
    ASSERT_THAT(talk.subscribed_channels(), testing::ElementsAreArray(wanted));
  }

 private:
  void show_channels() {
    std::vector<Channel> all;
    all.reserve(there.size());
    for (const auto& [number, one] : there) {
      all.push_back(one);
    }
    talk.show_channels(all);
  }

  std::vector<std::string> taken_ops() {
    std::vector<std::string> ops;
    for (const Frame& frame : take()) {
      ops.push_back(json::parse(frame.head)["op"]);
    }
    return ops;
  }

  std::mt19937 random{7};
  std::map<std::uint32_t, std::uint32_t> channel_of;  // channel of each subscription
  std::map<std::uint32_t, Channel> there;
};

TEST_F(TalkAndModel, HaveTheSameSubscriptions) {
  for (int i = 0; i < 20000; ++i) {
    const std::uint32_t id = below(6), channel = below(9), what = below(8);
    if (what <= 2) {
      a_subscription(id, channel);
    } else if (what == 3) {
      an_end(id);
    } else if (what == 4) {
      another_channel(channel);
    } else {
      a_message(channel, i);
    }
    be_the_same();
    if (HasFatalFailure()) {
      return;
    }
  }
}

TEST_F(Talk, ParameterUpdatesAreThoseOfTheModel) {
  std::mt19937 random(8);
  const std::vector<std::string> names{"a", "b", "c", "d"};
  std::map<std::string, bool> wanted;
  for (int i = 0; i < 5000; ++i) {
    json some = json::array();
    for (const std::string& name : names) {
      if (random() % 3 == 0) {
        some.push_back(name);
      }
    }
    if (random() % 10 == 0) {
      some = json::array();
    }
    const bool on = random() % 2 == 0;
    hear({{"op", on ? "subscribeParameterUpdates" : "unsubscribeParameterUpdates"},
          {"parameterNames", some}});
    for (const std::string& name : names) {
      if (some.empty() || std::ranges::find(some, json(name)) != some.end()) {
        wanted[name] = on;
      }
    }
    std::vector<NamedValue> changed;
    json expected = json::array();
    for (const std::string& name : names) {
      changed.push_back({name, "1"});
      if (wanted[name]) {
        expected.push_back({{"name", name}, {"value", 1}});
      }
    }
    talk.parameters_changed(changed);
    if (expected.empty()) {
      ASSERT_THAT(take(), IsEmpty());
    } else {
      ASSERT_EQ(only(), json({{"op", "parameterValues"}, {"parameters", expected}}));
    }
  }
}

// Whatever comes, at most one sentence goes back, and it is UTF-8 in JSON.
TEST_F(Talk, RandomInputIsAnsweredOnce) {
  std::mt19937 random(9);
  const std::string good[] = {
      R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":2},{"id":2,"channelId":7}]})",
      R"({"op":"unsubscribe","subscriptionIds":[1,2]})",
      R"({"op":"setParameters","parameters":[{"name":"a","value":[1,{"b":2}]}],"id":"x"})",
      request(1, 7, "json", R"({"node":1})")};
  for (int i = 0; i < 50000; ++i) {
    std::string text = good[random() % 4];
    const std::uint32_t edits = 1 + random() % 4;
    for (std::uint32_t edit = 0; edit < edits && !text.empty(); ++edit) {
      const std::size_t at = random() % text.size();
      if (random() % 4 == 0) {
        text.erase(at, 1 + random() % 5);
      } else {
        text[at] = random() % 3 == 0 ? static_cast<char>(random()) : "{}[]\",:0"[random() % 8];
      }
    }
    desk.asked.clear();
    if (random() % 2 == 0) {
      talk.hear_bytes(text);
    } else {
      talk.hear_text(text);
    }
    const std::vector<Frame> frames = take();
    ASSERT_LE(frames.size() + desk.asked.size(), 1U);
    for (const Frame& frame : frames) {
      ASSERT_TRUE(json::accept(frame.head));
    }
    for (const std::string& asked : desk.asked) {
      if (asked.starts_with("call")) {
        talk.answer(1, 7, {.ok = true, .text = "{}"});
      } else {
        talk.parameter_values({}, std::nullopt, "");
      }
      take();
    }
  }
}

}  // namespace
}  // namespace smaservo::page
