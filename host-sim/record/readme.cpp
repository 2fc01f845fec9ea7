#include "host-sim/record/readme.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

#include "host-sim/record/card/card_keys.hpp"
#include "host-sim/record/contents.hpp"
#include "host-sim/record/folder.hpp"
#include "host-sim/shell_word.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::record {
namespace {

bool can(const inspect::Facts& facts, const std::string& what) {
  const auto use = std::ranges::find(facts.uses, what, &inspect::Use::name);
  return use != facts.uses.end() && !use->command.empty();
}

bool has_column(const inspect::Facts& facts, std::string_view meaning) {
  return std::ranges::any_of(
      facts.columns, [&](const inspect::ColumnFacts& column) { return column.meaning == meaning; });
}

std::string reference_of(const inspect::Facts& facts) {
  return has_column(facts, "strain_ref")     ? "strain_ref"
         : has_column(facts, "displacement") ? "displacement"
                                             : "none";
}

std::string runs_table(const std::vector<RunFacts>& runs) {
  files::TextTable table({{"run"},
                          {"rows", "{}"},
                          {"s", "{:.4g}"},
                          {"rows/s", "{:.4g}"},
                          {"heatings", "{}"},
                          {"MPa"},
                          {"ohm"},
                          {"reference"}},
                         "");
  for (const auto& [name, facts] : runs) {
    std::vector<std::string> loads;
    std::ranges::transform(facts.loads_MPa, std::back_inserter(loads),
                           [](double load) { return fmt::format("{:.0f}", load); });
    table.add({fmt::format("[{0}]({1})", name, path_of_run(name)), facts.rows, facts.duration_s,
               facts.step_s > 0 ? 1 / facts.step_s : 0.0, facts.heatings,
               fmt::format("{}", fmt::join(loads, ", ")),
               facts.resistances > 0
                   ? fmt::format("{:.4g} to {:.4g}", facts.ohm_low, facts.ohm_high)
                   : "",
               reference_of(facts)});
  }
  return table.markdown();
}

std::string card_table(const Card& card, const CardTable& of) {
  std::string text = fmt::format("\n### {}\n\n| | | |\n|---|---|---|\n", of.meaning);
  for (const CardKey& key : card_keys()) {
    const auto value = card.values.find(key.path);
    if (table_of(key) != of.name || value == card.values.end()) {
      continue;
    }
    // What follows is for those who fill the card in.
    const std::string_view meaning = key.meaning.substr(0, key.meaning.find(';'));
    text += fmt::format("| {} | {} | {} |\n", markdown_text(std::string(name_of(key))),
                        markdown_text(value->second.shown), markdown_text(std::string(meaning)));
  }
  return text;
}

/// The words of a command for these runs, of `all`.
std::string run_words(const std::vector<std::string>& runs, std::size_t all) {
  if (all > 1 && runs.size() == all) {
    return fmt::format(" {}/*.csv", runs_name);
  }
  std::string words;
  for (const std::string& run : runs) {
    words += " " + shell_word(path_of_run(run));
  }
  return words;
}

std::string commands(const std::vector<RunFacts>& runs) {
  std::vector<std::string> sound, replayed, identified;
  std::set<std::string_view> failing;
  for (const auto& [name, facts] : runs) {
    if (can(facts, "replay")) {
      replayed.push_back(name);
    }
    if (can(facts, "identify")) {
      identified.push_back(name);
    }
    bool is_sound = true;
    for (const checks::Finding& finding : facts.findings) {
      if (finding.is_error) {
        failing.insert(finding.check);
        is_sound = false;
      }
    }
    if (is_sound) {  // inspect ends with 1 where it finds a mistake
      sound.push_back(name);
    }
  }
  std::string allow;
  for (const std::string_view check : failing) {
    allow += fmt::format(" --allow {}", check);
  }
  std::string text = fmt::format(
      "\n## How to use them\n\n"
      "`sha256sum -c {}` says whether all files are as they were made; `host-sim` is the program\n"
      "of smaservo, with which this folder was made. In this folder:\n\n"
      "    host-sim record --check .{}\n",
      sums_name, allow);
  if (!sound.empty()) {
    text +=
        fmt::format("    host-sim inspect --wire {}{}\n", wire_name, run_words(sound, runs.size()));
  }
  if (!replayed.empty()) {
    text += fmt::format("    host-sim replay --wire {}{} --report report.html {}\n", wire_name,
                        allow, shell_word(path_of_run(replayed.front())));
  }
  if (identified.empty()) {
    text +=
        "\nNo run has a displacement or strain, so `identify` cannot use them, and nobody can "
        "tell the\nerror of an estimate.\n";
    return text;
  }
  return text + fmt::format("    host-sim identify --from {}{} --out fitted.toml{}\n", wire_name,
                            allow, run_words(identified, runs.size()));
}

std::string found_by_checks(const std::vector<RunFacts>& runs) {
  std::string text;
  for (const auto& [name, facts] : runs) {
    for (const checks::Finding& finding : facts.findings) {
      text += fmt::format("- {}: {} (`{}`): {}\n", markdown_text(name),
                          finding.is_error ? "mistake" : "note", finding.check,
                          markdown_text(finding.text));
    }
  }
  return fmt::format("\n## What the checks find\n\n{}", text.empty() ? "Nothing.\n" : text);
}

std::string licence_line(const std::string& licence) {
  return licence.starts_with("LicenseRef-")
             ? fmt::format("Licence: {}, a licence of its own; ask who measured.\n", licence)
             : fmt::format("Licence: [{0}](https://spdx.org/licenses/{0}.html).\n", licence);
}

}  // namespace

std::string markdown_text(const std::string& text) {
  std::string line;
  for (const char c : text) {
    line += c == '\n' || c == '\t' || c == '\r' ? ' ' : c;
  }
  constexpr std::string_view special = "\\`*_{}[]<>#|&!~";
  std::string escaped;
  for (const char c : files::printable(line)) {
    escaped += (special.find(c) != std::string_view::npos ? "\\" : "") + std::string(1, c);
  }
  return escaped;
}

std::string readme_text(const Card& card, const std::string& preset,
                        const std::vector<RunFacts>& runs) {
  const std::string when = card.word("data.when");
  std::string text = fmt::format(
      "# {}\n\n{} of a shape-memory-alloy wire, measured by {}{}.\n{}\n"
      "`host-sim record` has made this file from `{}`, and makes it again when runs are added.\n\n"
      "## Runs\n\n{}\n"
      "`{}` has each of these as CSV; a column's name is its quantity and unit: `time`, `current`\n"
      "through the wire, `voltage` at it (or `resistance`), `load` that pulls it (or `stress`);\n"
      "`displacement` is its contraction from any zero, `strain_ref` its elongation, both by a\n"
      "sensor. Other columns are as the bench wrote them. Numbers have the digits that were\n"
      "recorded. `{}` describes the wire, from the preset `{}` with the length, diameter and\n"
      "cold resistance of the card, where it knows them; its other parameters are those of the "
      "type, not of this wire.\n",
      markdown_text(card.word("data.title")), runs.size() == 1 ? "A recording" : "Recordings",
      markdown_text(card.word("data.by")), when == unknown_word ? "" : ", " + markdown_text(when),
      licence_line(card.word("data.licence")), card_name, runs_table(runs), runs_name, wire_name,
      preset);
  text += commands(runs) + found_by_checks(runs) + "\n## Data card\n";
  for (const CardTable& table : card_tables()) {
    text += card_table(card, table);
  }
  return text;
}

}  // namespace smaservo::record
