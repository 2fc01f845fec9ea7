#pragma once
// What the server says in the Foxglove WebSocket protocol, as frames.

#include <map>
#include <optional>
#include <span>
#include <string_view>

#include "host-sim/page/protocol/send_queue.hpp"
#include "host-sim/page/source.hpp"

namespace smaservo::page {

/// The encoding of services' requests and answers.
constexpr std::string_view service_encoding = "json";

/// The server's information about itself.
struct ServerInfo {
  std::string version;
  std::string session;  ///< differs for each run of the server
  std::uint32_t client;
  bool read_only;
  std::string units;  ///< the page's first choice of units: "bench" or "si"
};

Frame server_info(const ServerInfo& info);
Frame advertise(const std::map<std::uint32_t, Channel>& channels);
Frame unadvertise(const std::vector<std::uint32_t>& channels);
Frame advertise_services(const std::vector<Service>& services);
Frame message_data(std::uint32_t subscription, std::int64_t time_ns,
                   const std::shared_ptr<const std::string>& bytes);
Frame parameters_frame(std::span<const NamedValue> values, const std::optional<std::string>& id);
Frame service_answer(std::uint32_t service, std::uint32_t call, Answer answer);
Frame status_frame(int level, std::string_view message);

}  // namespace smaservo::page
