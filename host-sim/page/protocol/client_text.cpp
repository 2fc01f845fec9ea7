#include "host-sim/page/protocol/client_text.hpp"

#include <fmt/format.h>
#include <limits>
#include <set>

#include "host-sim/page/protocol/limits.hpp"
#include "model/files/message.hpp"

namespace smaservo::page::said {

using nlohmann::json;

std::string in_words(std::string_view text) {
  constexpr std::size_t longest = 80;
  return text.size() <= longest ? files::printable(text)
                                : files::printable(text.substr(0, longest)) + "...";
}

std::string text_of(const json& document) {
  return document.dump(-1, ' ', false, json::error_handler_t::replace);
}

json parsed(std::string_view text) {
  const auto shallow = [](int depth, json::parse_event_t, const json&) {
    if (depth > limits::depth) {
      throw Malformed(fmt::format("nested deeper than {}", limits::depth));
    }
    return true;
  };
  json document;
  try {
    document = json::parse(text, shallow);
  } catch (const json::exception& error) {
    throw Malformed(fmt::format("no JSON: {}", in_words(error.what())));
  }
  if (!document.is_object()) {
    throw Malformed("not a JSON object");
  }
  return document;
}

const json& list(const json& object, const char* key, std::size_t longest) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) {
    throw Malformed(fmt::format("{}: an array is missing", key));
  }
  if (found->size() > longest) {
    throw Malformed(fmt::format("{}: {} elements, at most {}", key, found->size(), longest));
  }
  return *found;
}

std::uint32_t number(const json& value, const char* key) {
  if (!value.is_number_unsigned() ||
      value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
    throw Malformed(fmt::format("{}: a whole number of 32 bits is missing", key));
  }
  return value.get<std::uint32_t>();
}

std::uint32_t number_in(const json& object, const char* key) {
  if (!object.is_object() || !object.contains(key)) {
    throw Malformed(fmt::format("{}: a whole number of 32 bits is missing", key));
  }
  return number(object[key], key);
}

std::string text_in(const json& object, const char* key) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_string()) {
    throw Malformed(fmt::format("{}: a text is missing", key));
  }
  return object[key].get<std::string>();
}

std::vector<std::string> names_in(const json& object) {
  std::vector<std::string> names;
  for (const json& name : list(object, "parameterNames", limits::names)) {
    if (!name.is_string()) {
      throw Malformed("parameterNames: not a text");
    }
    names.push_back(name.get<std::string>());
  }
  return names;
}

std::optional<std::string> request_id(const json& object) {
  if (!object.contains("id")) {
    return std::nullopt;
  }
  return text_in(object, "id");
}

std::vector<NamedValue> values_in(const json& object) {
  std::vector<NamedValue> values;
  std::set<std::string> seen;
  for (const json& parameter : list(object, "parameters", limits::names)) {
    std::string name = text_in(parameter, "name");
    const auto value = parameter.find("value");
    if (value == parameter.end() || value->is_null()) {
      throw Malformed(fmt::format("{}: has no value; no parameter can be removed", in_words(name)));
    }
    if (!seen.insert(name).second) {
      throw Malformed(fmt::format("{}: stands there twice", in_words(name)));
    }
    values.push_back({std::move(name), text_of(*value)});
  }
  return values;
}

}  // namespace smaservo::page::said
