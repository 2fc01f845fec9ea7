#pragma once
// What a mistyped name may have meant.

#include <string>
#include <string_view>
#include <vector>

namespace smaservo::files {

/// At most three of the names that the word may have meant, the most similar first: by their edit
/// distance (Levenshtein) regardless of case, where a part of a name counts as one mistake. Names
/// that differ in more than a third of their letters, and one more, are none.
std::vector<std::string> similar(std::string_view word, const std::vector<std::string>& names);

/// " (did you mean wire_open or wire_short?)"; empty where no name is similar.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& names);

}  // namespace smaservo::files
