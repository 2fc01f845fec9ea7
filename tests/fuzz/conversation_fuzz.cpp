// What a client of the page's socket sends: texts, bytes, and between them what a server does. Each
// piece of the input is a kind, a length of two bytes, and so many bytes.

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "host-sim/page/protocol/foxglove.hpp"
#include "tests/fuzz/processor_limit.hpp"

namespace {

using namespace smaservo::page;

void demand(bool holds) {
  if (!holds) {
    std::abort();
  }
}

class FuzzedDesk final : public Desk {
 public:
  void send(Frame frame) override {
    ++sent;
    if (frame.binary) {
      demand(frame.head.size() >= 13);
    } else {
      demand(nlohmann::json::parse(frame.head)["op"].is_string());
    }
  }
  void subscribe(std::uint32_t channel, bool is_wanted) override {
    demand(wanted.contains(channel) != is_wanted);
    if (is_wanted) {
      wanted.insert(channel);
    } else {
      wanted.erase(channel);
    }
  }
  void get_parameters(std::vector<std::string> names, std::optional<std::string> id) override {
    demand(names.size() <= limits::names && (!id || id->size() <= limits::message_bytes));
    ++open;
  }
  void set_parameters(std::vector<NamedValue> values, std::optional<std::string> /*id*/) override {
    for (const NamedValue& one : values) {
      demand(nlohmann::json::accept(one.value));
    }
    last_set = std::move(values);
    ++open;
  }
  void call(std::uint32_t service, std::uint32_t /*call*/, std::string request) override {
    demand(service == 1 && nlohmann::json::parse(request).is_object());
    ++open;
  }

  std::set<std::uint32_t> wanted;
  std::vector<NamedValue> last_set;
  std::size_t sent = 0, open = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const smaservo::fuzz::ProcessorLimit limit;
  static const std::vector<Service> services{{1, "enable", "{}", "{}"}};
  const auto channels = [](unsigned bits) {
    std::vector<Channel> all;
    for (std::uint32_t id = 0; id < 4; ++id) {
      if ((bits >> id & 1U) != 0) {
        all.push_back({id, (bits & 16U) != 0 ? "/a" : "/b", "", "{}"});
      }
    }
    return all;
  };
  FuzzedDesk desk;
  Conversation talk(desk, services);
  talk.greet({.version = "1", .session = "", .client = 1, .read_only = false, .units = "bench"},
             channels(15));
  const std::string_view input(reinterpret_cast<const char*>(data), size);  // NOLINT(*-cast)
  for (std::size_t at = 0; at + 3 <= size;) {
    const std::size_t length =
        std::min<std::size_t>(data[at + 1] | std::size_t{data[at + 2]} << 8U, size - at - 3);
    const std::string_view piece = input.substr(at + 3, length);
    desk.sent = 0;
    const std::size_t open = desk.open;
    switch (data[at] % 6) {
      case 0:
      case 1:
        talk.hear_text(piece);
        demand(desk.sent + desk.open - open <= 1);
        break;
      case 2:
        talk.hear_bytes(piece);
        demand(desk.sent + desk.open - open == 1);
        break;
      case 3: {
        talk.show_channels(channels(data[at + 1]));
        const std::vector<std::uint32_t> left = talk.subscribed_channels();
        std::erase_if(desk.wanted,
                      [&](auto one) { return !std::ranges::binary_search(left, one); });
        break;
      }
      case 4:
        talk.message(data[at + 1] % 4U, 1, std::make_shared<std::string>(piece));
        demand(desk.sent == (desk.wanted.contains(data[at + 1] % 4U) ? 1U : 0U));
        break;
      default:
        if (desk.open > 0) {
          --desk.open;
          talk.parameter_values(desk.last_set, std::string(piece), piece);
        }
        talk.parameters_changed(desk.last_set);
    }
    const std::vector<std::uint32_t> subscribed = talk.subscribed_channels();
    demand(std::ranges::equal(subscribed, desk.wanted) && desk.open <= limits::calls);
    at += 3 + length;
  }
  return 0;
}
