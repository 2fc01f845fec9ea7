#pragma once
// The README.md of a data set, made from its card and its runs.

#include <string>
#include <utility>
#include <vector>

#include "host-sim/inspect/inspect.hpp"
#include "host-sim/record/card/card.hpp"

namespace smaservo::record {

/// A run's name and what is in it.
using RunFacts = std::pair<std::string, inspect::Facts>;

/// Tables of the runs and of the card, the commands that use them, and what the checks find. Texts
/// of the card are escaped, so that they cannot become Markdown or HTML.
std::string readme_text(const Card& card, const std::string& preset,
                        const std::vector<RunFacts>& runs);

/// A text as one line of Markdown, also in a table.
std::string markdown_text(const std::string& text);

}  // namespace smaservo::record
