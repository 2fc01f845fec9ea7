#include "host-sim/page/protocol/server_frames.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>

#include "host-sim/page/protocol/client_text.hpp"

namespace smaservo::page {
namespace {

using nlohmann::json;

enum ServerOpcode : std::uint8_t { data_of_message = 1, response_of_service = 3 };

template <class Number>
void append(std::string& bytes, Number number) {
  for (unsigned shift = 0; shift < 8 * sizeof(Number); shift += 8) {
    bytes.push_back(static_cast<char>(number >> shift & 0xFFU));
  }
}

Frame text_frame(const json& document) {
  return {.head = said::text_of(document), .body = {}};
}

json channel_json(const Channel& channel) {
  const bool is_json = channel.encoding == Encoding::json;
  return {{"id", channel.id},
          {"topic", channel.topic},
          {"encoding", is_json ? "json" : "cdr"},
          {"schemaName", channel.schema_name},
          {"schema", channel.schema},
          {"schemaEncoding", is_json ? "jsonschema" : "ros2msg"}};
}

json service_json(const Service& service) {
  const auto side = [&](const char* name, const std::string& schema) {
    return json{{"encoding", service_encoding},
                {"schemaName", service.name + name},
                {"schemaEncoding", "jsonschema"},
                {"schema", schema}};
  };
  return {{"id", service.id},
          {"name", service.name},
          {"type", service.name},
          {"request", side("_request", service.request_schema)},
          {"response", side("_response", service.response_schema)}};
}

}  // namespace

Frame server_info(const ServerInfo& info) {
  return text_frame({{"op", "serverInfo"},
                     {"name", "smaservo"},
                     {"capabilities", {"parameters", "parametersSubscribe", "services"}},
                     {"supportedEncodings", {service_encoding}},
                     {"metadata",
                      {{"version", info.version},
                       {"client", fmt::format("{}", info.client)},
                       {"read_only", info.read_only ? "true" : "false"},
                       {"units", info.units}}},
                     {"sessionId", info.session}});
}

Frame advertise(const std::map<std::uint32_t, Channel>& channels) {
  json all = json::array();
  for (const auto& [id, channel] : channels) {
    all.push_back(channel_json(channel));
  }
  return text_frame({{"op", "advertise"}, {"channels", all}});
}

Frame unadvertise(const std::vector<std::uint32_t>& channels) {
  return text_frame({{"op", "unadvertise"}, {"channelIds", channels}});
}

Frame advertise_services(const std::vector<Service>& services) {
  json all = json::array();
  for (const Service& service : services) {
    all.push_back(service_json(service));
  }
  return text_frame({{"op", "advertiseServices"}, {"services", all}});
}

Frame message_data(std::uint32_t subscription, std::int64_t time_ns,
                   const std::shared_ptr<const std::string>& bytes) {
  Frame frame{.binary = true, .live = true, .head = {}, .body = bytes};
  frame.head.push_back(data_of_message);
  append(frame.head, subscription);
  append(frame.head, static_cast<std::uint64_t>(time_ns));
  return frame;
}

Frame parameters_frame(std::span<const NamedValue> values, const std::optional<std::string>& id) {
  json all = json::array();
  for (const NamedValue& value : values) {
    json parameter{{"name", value.name}, {"value", json::parse(value.value, nullptr, false)}};
    if (parameter["value"].is_discarded()) {
      parameter["value"] = value.value;
    }
    // The type makes a client keep 4.0 a number with decimals.
    if (parameter["value"].is_number_float()) {
      parameter["type"] = "float64";
    }
    all.push_back(std::move(parameter));
  }
  json message{{"op", "parameterValues"}, {"parameters", std::move(all)}};
  if (id) {
    message["id"] = *id;
  }
  return text_frame(message);
}

Frame service_answer(std::uint32_t service, std::uint32_t call, Answer answer) {
  if (!answer.ok) {
    return text_frame({{"op", "serviceCallFailure"},
                       {"serviceId", service},
                       {"callId", call},
                       {"message", answer.text}});
  }
  Frame frame{
      .binary = true, .head = {}, .body = std::make_shared<std::string>(std::move(answer.text))};
  frame.head.push_back(response_of_service);
  append(frame.head, service);
  append(frame.head, call);
  append(frame.head, static_cast<std::uint32_t>(service_encoding.size()));
  frame.head += service_encoding;
  return frame;
}

Frame status_frame(int level, std::string_view message) {
  return text_frame({{"op", "status"}, {"level", level}, {"message", message}});
}

}  // namespace smaservo::page
