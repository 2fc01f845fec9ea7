#pragma once
// Reads the parts of a client's text, each as its expected type. All functions throw Malformed.

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/page/source.hpp"
#include "model/files/error.hpp"

namespace smaservo::page::said {

/// An error in a client's message; it becomes a status message.
class Malformed : public files::Error {
 public:
  using Error::Error;
};

/// Collects the errors of some elements of a list in one sentence.
class Complaints {
 public:
  void add(std::string text) {
    if (count_++ == 0) {
      first_ = std::move(text);
    }
  }
  std::string text() const {
    return count_ < 2 ? first_ : fmt::format("{}; and {} more", first_, count_ - 1);
  }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

/// A text of a client as a part of a message to a person.
std::string in_words(std::string_view text);
/// The document on one line; bytes that are not UTF-8 are replaced.
std::string text_of(const nlohmann::json& document);

/// The object that the text contains; its nesting is bounded.
nlohmann::json parsed(std::string_view text);
/// The array under a key; it must have at most `longest` elements.
const nlohmann::json& list(const nlohmann::json& object, const char* key, std::size_t longest);
/// The value as a whole number of 32 bits; `key` names it in messages.
std::uint32_t number(const nlohmann::json& value, const char* key);
std::uint32_t number_in(const nlohmann::json& object, const char* key);
std::string text_in(const nlohmann::json& object, const char* key);
/// The names under parameterNames.
std::vector<std::string> names_in(const nlohmann::json& object);
std::optional<std::string> request_id(const nlohmann::json& object);
/// The values under parameters.
std::vector<NamedValue> values_in(const nlohmann::json& object);

}  // namespace smaservo::page::said
