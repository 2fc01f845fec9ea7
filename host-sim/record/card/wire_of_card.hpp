#pragma once
// The wire that a card describes.

#include "host-sim/record/card/card.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::record {

/// The card's preset, or the one of the nearest diameter, with the card's length, diameter and
/// resistance. Its sources say so. Throws UserError for a card that parse_card() finds fault with.
files::WireDescription wire_of(const Card& card);

/// The preset that wire_of() starts from.
std::string preset_of(const Card& card);

}  // namespace smaservo::record
