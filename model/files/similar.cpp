#include "model/files/similar.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numeric>
#include <utility>

namespace smaservo::files {
namespace {

std::string lower(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
  return small;
}

/// The edit distance of Levenshtein.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      diagonal = above;
    }
  }
  return row.back();
}

}  // namespace

std::vector<std::string> similar(std::string_view word, const std::vector<std::string>& names) {
  constexpr std::size_t longest = 100, most = 3, shortest_part = 3;
  const std::string wanted = lower(word.substr(0, longest));
  std::vector<std::pair<std::size_t, std::string>> candidates;
  for (const std::string& name : names) {
    const std::string known = lower(name);
    const bool part = wanted.size() >= shortest_part && known.find(wanted) != std::string::npos;
    const std::size_t mistakes = part ? 1 : distance(wanted, known);
    if (mistakes <= 1 + name.size() / 3 && mistakes < std::max(wanted.size(), known.size())) {
      candidates.emplace_back(mistakes, name);
    }
  }
  std::ranges::sort(candidates);
  std::vector<std::string> close;
  for (std::size_t i = 0; i < std::min(candidates.size(), most); ++i) {
    close.push_back(candidates[i].second);
  }
  return close;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& names) {
  const std::vector<std::string> close = similar(word, names);
  return close.empty() ? "" : fmt::format(" (did you mean {}?)", fmt::join(close, " or "));
}

}  // namespace smaservo::files
