#pragma once
// The keys of a data card, described once: the reader, the empty card and the table that strangers
// read are made of them.

#include <span>
#include <string>
#include <string_view>

#include "model/units.hpp"

namespace smaservo::record {

enum class CardType : unsigned char {
  text,
  number,   ///< in one of the units of its kind
  whole,    ///< a number without fraction
  choice,   ///< one of `choices`
  flag,     ///< true or false
  date,     ///< "2026-11-30", or two of them: "2026-11-28/2026-11-30"
  preset,   ///< a built-in wire
  licence,  ///< an SPDX identifier
};

/// A key that stands in a card only where another key has this value, or has not.
struct CardCondition {
  std::string_view path, value;  ///< an empty path: always
  bool is_not = false;
};

struct CardKey {
  std::string_view path;  ///< "wire.length": table and name, without unit
  CardType type;
  std::string_view meaning;
  std::string_view example;  ///< as a card writes it
  /// Whether "unknown" is refused: a replay needs it, or nobody may use the data without it.
  bool is_needed = false;
  // NOLINTBEGIN(readability-redundant-member-init): g++ warns of members that are left out
  Kind kind = {};
  std::string_view unit = {};  ///< in which the empty card has it
  double low = 0, high = 0;    ///< SI
  std::span<const std::string_view> choices = {};
  CardCondition only = {};
  std::string_view word = {};  ///< a text that stands for the number
  // NOLINTEND(readability-redundant-member-init)
};

std::span<const CardKey> card_keys();

/// What each table is about; in the order of the keys.
struct CardTable {
  std::string_view name, meaning;
};
std::span<const CardTable> card_tables();

/// Identifiers of licences that are taken; LicenseRef-... is, too.
std::span<const std::string_view> known_licences();

/// "wire", "length" of "wire.length".
std::string_view table_of(const CardKey& key);
std::string_view name_of(const CardKey& key);

/// A card to fill in, with comments. What must be known is commented out, so that a card as it is
/// printed is refused with a list of it.
std::string empty_card();

inline constexpr std::string_view unknown_word = "unknown";

}  // namespace smaservo::record
