#include "host-sim/page/protocol/foxglove.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "host-sim/page/protocol/client_text.hpp"
#include "host-sim/page/protocol/server_frames.hpp"

namespace smaservo::page {
namespace {

using nlohmann::json;
using said::Complaints;
using said::in_words;
using said::list;
using said::Malformed;
using said::names_in;
using said::number;
using said::number_in;
using said::parsed;
using said::request_id;
using said::text_in;
using said::text_of;
using said::values_in;

enum ClientOpcode : std::uint8_t { client_message = 1, service_request = 2 };

std::uint32_t take_u32(std::string_view& bytes) {
  std::uint32_t number = 0;
  for (unsigned i = 0; i < 4; ++i) {
    number |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << (8 * i);
  }
  bytes.remove_prefix(4);
  return number;
}

bool same(const Channel& a, const Channel& b) {
  return a.topic == b.topic && a.schema_name == b.schema_name && a.schema == b.schema &&
         a.encoding == b.encoding;
}

std::map<std::uint32_t, Channel> by_id(const std::vector<Channel>& channels) {
  std::map<std::uint32_t, Channel> all;
  for (const Channel& channel : channels) {
    all.emplace(channel.id, channel);
  }
  return all;
}

}  // namespace

/// The reading of one text, which contains one operation; each operation has a function.
struct Conversation::Reading {
  Conversation& self;
  const json& message;

  void subscribe() const {
    Complaints wrong;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted;
    for (const json& one : list(message, "subscriptions", limits::subscriptions)) {
      const std::uint32_t id = number_in(one, "id");
      wanted.emplace_back(id, number_in(one, "channelId"));
    }
    for (const auto& [id, channel] : wanted) {
      if (!self.channels_.contains(channel)) {
        wrong.add(fmt::format("channel {} does not exist", channel));
      } else if (self.by_subscription_.contains(id)) {
        wrong.add(fmt::format("subscription {} is in use", id));
      } else if (self.by_channel_.contains(channel)) {
        wrong.add(fmt::format("channel {} is subscribed already", channel));
      } else if (self.by_channel_.size() == limits::subscriptions) {
        wrong.add(fmt::format("at most {} subscriptions", limits::subscriptions));
      } else {
        self.by_subscription_.emplace(id, channel);
        self.by_channel_.emplace(channel, id);
        self.desk_.subscribe(channel, true);
      }
    }
    complain(wrong);
  }

  void unsubscribe() const {
    Complaints wrong;
    std::vector<std::uint32_t> ids;
    for (const json& id : list(message, "subscriptionIds", limits::subscriptions)) {
      ids.push_back(number(id, "subscriptionIds"));
    }
    for (const std::uint32_t id : ids) {
      const auto found = self.by_subscription_.find(id);
      if (found == self.by_subscription_.end()) {
        wrong.add(fmt::format("there is no subscription {}", id));
        continue;
      }
      const std::uint32_t channel = found->second;
      self.by_channel_.erase(channel);
      self.by_subscription_.erase(found);
      self.desk_.subscribe(channel, false);
    }
    complain(wrong);
  }

  void get_parameters() const {
    std::vector<std::string> names = names_in(message);
    std::optional<std::string> id = request_id(message);
    if (self.may_ask("getParameters")) {
      self.desk_.get_parameters(std::move(names), std::move(id));
    }
  }

  void set_parameters() const {
    std::vector<NamedValue> values = values_in(message);
    std::optional<std::string> id = request_id(message);
    if (self.may_ask("setParameters")) {
      self.desk_.set_parameters(std::move(values), std::move(id));
    }
  }

  /// Adds or removes the names of the message. `named_` has the wanted parameters or, if wants_all_
  /// is set, the unwanted ones.
  void want(bool wanted) const {
    const std::vector<std::string> names = names_in(message);
    if (names.empty()) {
      self.named_.clear();
      self.wants_all_ = wanted;
    }
    if (self.named_.size() + names.size() > limits::names) {
      throw Malformed(fmt::format("at most {} names", limits::names));
    }
    for (const std::string& name : names) {
      if (wanted == self.wants_all_) {
        self.named_.erase(name);
      } else {
        self.named_.insert(name);
      }
    }
  }

  static void complain(const Complaints& wrong) {
    if (!wrong.text().empty()) {
      throw Malformed(wrong.text());
    }
  }

  void run(std::string_view op) const {
    constexpr std::array not_offered{"advertise", "unadvertise", "subscribeConnectionGraph",
                                     "unsubscribeConnectionGraph", "fetchAsset"};
    if (op == "subscribe") {
      subscribe();
    } else if (op == "unsubscribe") {
      unsubscribe();
    } else if (op == "getParameters") {
      get_parameters();
    } else if (op == "setParameters") {
      set_parameters();
    } else if (op == "subscribeParameterUpdates") {
      want(true);
    } else if (op == "unsubscribeParameterUpdates") {
      want(false);
    } else if (std::ranges::find(not_offered, op) != not_offered.end()) {
      throw Malformed("is not offered; serverInfo has the capabilities");
    } else {
      throw Malformed("no such operation");
    }
  }
};

void Conversation::greet(const ServerInfo& info, const std::vector<Channel>& channels) {
  desk_.send(server_info(info));
  channels_ = by_id(channels);
  // The protocol demands at least one such message.
  desk_.send(advertise(channels_));
  desk_.send(advertise_services(services_));
}

void Conversation::hear_text(std::string_view text) {
  std::string op;
  try {
    if (text.size() > limits::message_bytes) {
      throw Malformed(fmt::format("longer than {} bytes", limits::message_bytes));
    }
    const json message = parsed(text);
    op = text_in(message, "op");
    Reading{*this, message}.run(op);
  } catch (const Malformed& error) {
    status(Level::error, op.empty() ? error.what() : in_words(op) + ": " + error.what());
  }
}

void Conversation::hear_bytes(std::string_view bytes) {
  constexpr std::size_t head = 13;
  const auto opcode = static_cast<std::uint8_t>(bytes.empty() ? 0 : bytes[0]);
  if (opcode != service_request) {
    status(Level::error, opcode == client_message
                             ? "messages of clients are not taken; serverInfo has the capabilities"
                             : fmt::format("no such binary operation: {}", opcode));
    return;
  }
  if (bytes.size() < head || bytes.size() > limits::message_bytes) {
    status(Level::error, fmt::format("a service request has {} to {} bytes, not {}", head,
                                     limits::message_bytes, bytes.size()));
    return;
  }
  bytes.remove_prefix(1);
  const std::uint32_t service = take_u32(bytes);
  const std::uint32_t number = take_u32(bytes);
  const std::uint32_t length = take_u32(bytes);
  const auto fail = [&](const std::string& why) {
    ++open_;
    answer(service, number, {.ok = false, .text = why});
  };
  if (std::ranges::find(services_, service, &Service::id) == services_.end()) {
    fail(fmt::format("there is no service {}", service));
    return;
  }
  if (length > bytes.size() || bytes.substr(0, length) != service_encoding) {
    fail("the encoding of a request must be json");
    return;
  }
  if (open_ >= limits::calls) {
    fail(fmt::format("{} requests are not answered yet", open_));
    return;
  }
  bytes.remove_prefix(length);
  try {
    std::string request = text_of(parsed(bytes));
    ++open_;
    desk_.call(service, number, std::move(request));
  } catch (const Malformed& error) {
    fail(error.what());
  }
}

void Conversation::drop_channels(const std::map<std::uint32_t, Channel>& now) {
  std::vector<std::uint32_t> gone;
  for (const auto& [id, channel] : channels_) {
    const auto found = now.find(id);
    if (found != now.end() && same(found->second, channel)) {
      continue;
    }
    gone.push_back(id);
    if (const auto wanted = by_channel_.find(id); wanted != by_channel_.end()) {
      by_subscription_.erase(wanted->second);
      by_channel_.erase(wanted);
    }
  }
  if (!gone.empty()) {
    desk_.send(unadvertise(gone));
  }
}

void Conversation::show_channels(const std::vector<Channel>& channels) {
  std::map<std::uint32_t, Channel> now = by_id(channels);
  drop_channels(now);
  std::map<std::uint32_t, Channel> come;
  for (const auto& [id, channel] : now) {
    const auto before = channels_.find(id);
    if (before == channels_.end() || !same(before->second, channel)) {
      come.emplace(id, channel);
    }
  }
  channels_ = std::move(now);
  if (!come.empty()) {
    desk_.send(advertise(come));
  }
}

void Conversation::message(std::uint32_t channel, std::int64_t time_ns,
                           const std::shared_ptr<const std::string>& bytes) {
  const auto wanted = by_channel_.find(channel);
  if (wanted != by_channel_.end()) {
    desk_.send(message_data(wanted->second, time_ns, bytes));
  }
}

void Conversation::parameter_values(std::span<const NamedValue> values,
                                    const std::optional<std::string>& id,
                                    std::string_view refusal) {
  --open_;
  desk_.send(parameters_frame(values, id));
  if (!refusal.empty()) {
    status(Level::error, refusal);
  }
}

void Conversation::parameters_changed(std::span<const NamedValue> values) {
  std::vector<NamedValue> mine;
  std::ranges::copy_if(values, std::back_inserter(mine), [&](const NamedValue& value) {
    return named_.contains(value.name) != wants_all_;
  });
  if (!mine.empty()) {
    desk_.send(parameters_frame(mine, std::nullopt));
  }
}

void Conversation::answer(std::uint32_t service, std::uint32_t call, Answer answer) {
  --open_;
  desk_.send(service_answer(service, call, std::move(answer)));
}

void Conversation::status(Level level, std::string_view message) {
  desk_.send(status_frame(static_cast<int>(level), message));
}

bool Conversation::may_ask(const char* what) {
  if (open_ >= limits::calls) {
    status(Level::error, fmt::format("{}: {} requests are not answered yet", what, open_));
    return false;
  }
  ++open_;
  return true;
}

std::vector<std::uint32_t> Conversation::subscribed_channels() const {
  std::vector<std::uint32_t> all;
  all.reserve(by_channel_.size());
  for (const auto& [channel, id] : by_channel_) {
    all.push_back(channel);
  }
  return all;
}

}  // namespace smaservo::page
