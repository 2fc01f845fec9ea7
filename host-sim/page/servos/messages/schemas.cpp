#include "host-sim/page/servos/messages/schemas.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "firmware/signals.hpp"
#include "host-sim/page/servos/messages/tables.hpp"

namespace smaservo::page {
namespace {

using nlohmann::json;

json object_schema(const json& properties) {
  return {{"type", "object"}, {"properties", properties}};
}
json typed(const char* type) {
  return {{"type", type}};
}
json list_of(const json& items) {
  return {{"type", "array"}, {"items", items}};
}
/// An object whose members are not always present, or not worth a list here.
json some_object() {
  return object_schema(json::object());
}

json live_members() {
  json members;
  for (const Signal<float>& row : signal_rows<float>) {
    members[std::string(row.name)] = {{"type", "number"}, {"description", row.meaning}};
  }
  return members;
}

}  // namespace

std::string bridge_schema() {
  const json node = object_schema({{"node", typed("integer")},
                                   {"name", typed("string")},
                                   {"online", typed("boolean")},
                                   {"duplicate", typed("boolean")}});
  const json client = object_schema({{"client", typed("integer")},
                                     {"address", typed("string")},
                                     {"queued", typed("integer")},
                                     {"dropped", typed("integer")},
                                     {"read_only", typed("boolean")}});
  const json activity = object_schema({{"service", typed("string")},
                                       {"node", typed("integer")},
                                       {"client", typed("integer")},
                                       {"progress", typed("number")}});
  const json recording = object_schema(
      {{"node", typed("integer")}, {"client", typed("integer")}, {"stage", typed("string")}});
  return json_text(object_schema({{"bus", typed("string")},
                                  {"read_only", typed("boolean")},
                                  {"nodes", list_of(node)},
                                  {"control", typed("integer")},
                                  {"clients", list_of(client)},
                                  {"activity", activity},
                                  {"recordings", list_of(recording)},
                                  {"trouble", typed("string")}}));
}

std::string live_schema() {
  return json_text(object_schema(live_members()));
}

std::string live_definition() {
  std::string text;
  for (const Signal<float>& row : signal_rows<float>) {
    std::string name(row.name);
    std::ranges::transform(name, name.begin(), [](char letter) {
      return 'A' <= letter && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
    });
    text += fmt::format("# {}\nfloat32 {}\n", row.meaning, name);
  }
  return text;
}

std::string state_schema() {
  json properties;
  for (const char* name : {"node", "statusword", "mode", "position_um", "gaps"}) {
    properties[name] = typed("integer");
  }
  for (const char* name : {"online", "target_reached", "unsaved"}) {
    properties[name] = typed("boolean");
  }
  for (const char* name : {"nmt", "drive", "mode_name"}) {
    properties[name] = typed("string");
  }
  for (const char* name : {"active", "latched", "warnings", "blocking", "limits"}) {
    properties[name] = list_of(typed("string"));
  }
  properties["warning_causes"] = some_object();
  properties["rate_hz"] = typed("number");
  properties["target"] = typed("number");
  properties["first_cause"] = typed("string");
  properties["freeze_frame"] = object_schema(live_members());
  properties["transaction"] =
      object_schema({{"state", typed("string")}, {"seconds_left", typed("number")}});
  return json_text(object_schema(properties));
}

std::string commission_schema() {
  json properties;
  for (const char* name : {"node", "client"}) {
    properties[name] = typed("integer");
  }
  for (const char* name : {"stage", "line", "error"}) {
    properties[name] = typed("string");
  }
  for (const char* name : {"said", "files"}) {
    properties[name] = list_of(typed("string"));
  }
  for (const char* name : {"left_s", "share"}) {
    properties[name] = typed("number");
  }
  properties["result"] = object_schema({{"text", typed("string")},
                                        {"numbers", some_object()},
                                        {"notes", list_of(typed("string"))},
                                        {"differences", list_of(some_object())}});
  return json_text(object_schema(properties));
}

std::string request_schema(std::string_view members) {
  json properties = json::object();
  json required = json::array();
  for (std::size_t at = 0; at < members.size();) {
    const std::size_t end = std::min(members.find(' ', at), members.size());
    std::string name(members.substr(at, end - at));
    const std::size_t colon = name.find(':');
    const std::string type = name.substr(colon + 1);
    name.resize(colon);
    if (name.ends_with('?')) {
      name.pop_back();
    } else {
      required.push_back(name);
    }
    properties[name] = type == "strings"  ? list_of(typed("string"))
                       : type == "object" ? some_object()
                                          : typed(type.c_str());
    at = end + 1;
  }
  json schema = object_schema(properties);
  schema["required"] = required;
  return json_text(schema);
}

std::string answer_schema() {
  return json_text(some_object());
}

}  // namespace smaservo::page
