#pragma once
// A data card: what a stranger must know of recordings to use them. card_keys.hpp has its keys.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::record {

/// What a card says under one key.
struct CardValue {
  std::string key;           ///< as written, with its unit: "wire.length_mm"
  std::string written;       ///< the number or text: "120"
  std::string shown;         ///< for people: "120 mm", "yes", "unknown"
  std::optional<double> si;  ///< of a number; a flag is 0 or 1
  bool is_unknown = false;
};

struct Card {
  std::string origin;                                    ///< its path
  std::string text;                                      ///< of the whole file
  std::map<std::string, CardValue, std::less<>> values;  ///< by CardKey::path

  /// The number in SI; none where the card does not say it.
  std::optional<double> number(std::string_view path) const;
  /// The text; empty where the card does not have the key.
  std::string word(std::string_view path) const;
};

/// All that is wrong is added to `faults`: the place in the file, the key, its value, what is
/// allowed; keys that are missing are named together. The card then has what could be read.
Card parse_card(const std::string& text, const std::string& origin,
                std::vector<std::string>& faults);

/// Reads a card that must be right. Prints its faults on the standard error output and throws
/// UserError where it has any.
Card load_card(const std::string& path);

}  // namespace smaservo::record
