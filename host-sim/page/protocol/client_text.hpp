#pragma once
// What stands in a client's text, each part as what it must be. All throw Malformed.

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/page/source.hpp"
#include "model/files/error.hpp"

namespace smaservo::page::said {

/// What a client says wrongly; becomes a status message.
class Malformed : public files::Error {
 public:
  using Error::Error;
};

/// What is wrong with some elements of a list, as one sentence.
class Complaints {
 public:
  void add(std::string text) {
    if (count_++ == 0) first_ = std::move(text);
  }
  std::string text() const {
    return count_ < 2 ? first_ : fmt::format("{}; and {} more", first_, count_ - 1);
  }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

/// A text of a client within a message to a person.
std::string in_words(std::string_view text);
/// One line; bytes that are no UTF-8 are replaced.
std::string text_of(const nlohmann::json& document);

/// An object that is not too deep.
nlohmann::json parsed(std::string_view text);
/// The array under a key, of at most so many elements.
const nlohmann::json& list(const nlohmann::json& object, const char* key, std::size_t longest);
/// A whole number of 32 bits; `key` is for the message.
std::uint32_t number(const nlohmann::json& value, const char* key);
std::uint32_t number_in(const nlohmann::json& object, const char* key);
std::string text_in(const nlohmann::json& object, const char* key);
/// Those under parameterNames.
std::vector<std::string> names_in(const nlohmann::json& object);
std::optional<std::string> request_id(const nlohmann::json& object);
/// Those under parameters.
std::vector<NamedValue> values_in(const nlohmann::json& object);

}  // namespace smaservo::page::said
