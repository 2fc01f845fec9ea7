#include "host-sim/record/card/card.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iterator>
#include <numbers>
#include <sstream>

#include "host-sim/record/card/card_keys.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/message.hpp"
#include "model/files/similar.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/files/wire/wire_file.hpp"

namespace smaservo::record {
namespace {

constexpr std::size_t longest_text = 4000;

/// The names that a key may have in the file, with each of its units.
std::vector<std::string> spellings(const CardKey& key) {
  if (key.kind.empty()) {
    return {std::string(name_of(key))};
  }
  std::vector<std::string> all;
  for (const Unit& unit : key.kind) {
    all.push_back(files::key_with(name_of(key), unit.suffix));
  }
  return all;
}

/// The spelling that an empty card has.
std::string usual_spelling(const CardKey& key) {
  return files::key_with(key.path, key.unit);
}

std::vector<std::string> names_in(std::string_view table) {
  std::vector<std::string> all;
  for (const CardKey& key : card_keys()) {
    if (table_of(key) == table) {
      all.push_back(files::key_with(name_of(key), key.unit));
    }
  }
  return all;
}

/// A number as it stands in the file: its digits are what people have measured.
std::string written_number(const toml::node& node) {
  if (const auto* const whole = node.as_integer()) {
    return fmt::format("{}", whole->get());
  }
  return fmt::format("{}", node.value_or(0.0));
}

/// "2026-11-30", a day that exists.
bool is_day(std::string_view text) {
  unsigned year = 0, month = 0, day = 0;
  const auto part = [&](std::size_t at, std::size_t size, unsigned& value) {
    const char* const begin = text.data() + at;
    return std::from_chars(begin, begin + size, value).ptr == begin + size;
  };
  return text.size() == 10 && text[4] == '-' && text[7] == '-' && part(0, 4, year) &&
         part(5, 2, month) && part(8, 2, day) && year >= 1900 &&
         std::chrono::year_month_day(std::chrono::year(static_cast<int>(year)),
                                     std::chrono::month(month), std::chrono::day(day))
             .ok();
}

bool is_date(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) {
    return is_day(text);
  }
  const std::string_view first = text.substr(0, slash), last = text.substr(slash + 1);
  return is_day(first) && is_day(last) && first <= last;
}

/// "LicenseRef-" and what SPDX allows behind it.
bool is_own_licence(std::string_view text) {
  constexpr std::string_view begin = "LicenseRef-";
  return text.size() > begin.size() && text.starts_with(begin) &&
         std::ranges::all_of(text, [](char c) {
           return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') ||
                  c == '-' || c == '.';
         });
}

class CardReader {
 public:
  CardReader(Card& card, std::vector<std::string>& faults) : card_(card), faults_(faults) {}

  void read(const toml::table& root) {
    for (const auto& [name, node] : root) {
      const std::string table(name.str());
      if (std::ranges::find(card_tables(), table, &CardTable::name) == card_tables().end()) {
        std::vector<std::string> names;
        std::ranges::transform(card_tables(), std::back_inserter(names),
                               [](const CardTable& known) { return std::string(known.name); });
        fault(table, node,
              fmt::format("unknown table{}; a card has: {}", files::did_you_mean(table, names),
                          fmt::join(names, ", ")));
      } else if (const toml::table* const inner = node.as_table()) {
        read_table(table, *inner);
      } else {
        fault(table, node, fmt::format("must be a table: [{}]", table));
      }
    }
    // The table has its keys by name.
    std::ranges::sort(found_);
    std::ranges::transform(found_, std::back_inserter(faults_),
                           &std::pair<std::uint32_t, std::string>::second);
    check_presence();
    check_together();
  }

 private:
  void fault(const std::string& key, const toml::node& node, const std::string& reason) {
    found_.emplace_back(node.source().begin.line,
                        fmt::format("{}: {}", files::place(card_.origin, key, node), reason));
  }

  void read_table(const std::string& table, const toml::table& inner) {
    for (const auto& [name, node] : inner) {
      const std::string written = fmt::format("{}.{}", table, name.str());
      const auto found = std::ranges::find_if(card_keys(), [&](const CardKey& key) {
        return table_of(key) == table &&
               std::ranges::count(spellings(key), std::string(name.str())) > 0;
      });
      if (found == card_keys().end()) {
        fault(written, node, why_unknown(table, std::string(name.str())));
        continue;
      }
      present_.emplace(found->path, files::place(card_.origin, written, node));
      if (card_.values.contains(found->path)) {
        fault(written, node,
              fmt::format("is there already as {}", card_.values.find(found->path)->second.key));
        continue;
      }
      CardValue value{written, "", "", {}, false};
      if (take(*found, node, value)) {
        card_.values.emplace(found->path, value);
      }
    }
  }

  static std::string why_unknown(const std::string& table, const std::string& name) {
    for (const CardKey& key : card_keys()) {
      if (table_of(key) == table && (name + "_").starts_with(std::string(name_of(key)) + "_") &&
          !key.kind.empty()) {
        return fmt::format("unknown key or unit; allowed: {}", fmt::join(spellings(key), ", "));
      }
    }
    return fmt::format("unknown key{}; [{}] has: {}", files::did_you_mean(name, names_in(table)),
                       table, fmt::join(names_in(table), ", "));
  }

  /// False: the value is wrong, and a fault.
  bool take(const CardKey& key, const toml::node& node, CardValue& value) {
    const auto text = node.value<std::string>();
    if (text && *text == unknown_word) {
      value.is_unknown = true;
      value.written = value.shown = *text;
      if (key.is_needed) {
        fault(value.key, node, "must be known: a replay needs it, or who uses the data");
      }
      return !key.is_needed;
    }
    const std::string reason = key.type == CardType::number || key.type == CardType::whole
                                   ? number_fault(key, node, value)
                               : key.type == CardType::flag ? flag_fault(node, value)
                                                            : text_fault(key, node, value);
    if (!reason.empty()) {
      fault(value.key, node,
            key.is_needed ? reason : fmt::format("{}; or \"{}\"", reason, unknown_word));
    }
    return reason.empty();
  }

  static std::string number_fault(const CardKey& key, const toml::node& node, CardValue& value) {
    const auto text = node.value<std::string>();
    if (!key.word.empty() && text && *text == key.word) {
      value.written = value.shown = *text;
      return "";
    }
    const std::string_view suffix =
        std::string_view(value.key).substr(std::min(value.key.size(), key.path.size() + 1));
    const Unit unit = *std::ranges::find(key.kind, suffix, &Unit::suffix);
    const double low = unit.from_si(key.low), high = unit.from_si(key.high);
    const std::optional<double> number = files::number_of(node);
    // A bound that was converted has a rounding error.
    const double slack = 1e-9 * std::max(std::abs(low), std::abs(high));
    const bool fits = number && *number >= low - slack && *number <= high + slack &&
                      (key.type != CardType::whole || *number == std::floor(*number));
    if (!fits) {
      return fmt::format("must be a {} between {:.9g} and {:.9g}{}",
                         key.type == CardType::whole ? "whole number" : "number", low, high,
                         key.word.empty() ? "" : fmt::format(", or \"{}\"", key.word));
    }
    value.written = written_number(node);
    value.shown = suffix.empty() ? value.written : fmt::format("{} {}", value.written, suffix);
    value.si = unit.to_si(*number);
    return "";
  }

  static std::string flag_fault(const toml::node& node, CardValue& value) {
    if (!node.is_boolean()) {
      return "must be true or false";
    }
    const bool is_true = node.value_or(false);
    value.written = is_true ? "true" : "false";
    value.shown = is_true ? "yes" : "no";
    value.si = is_true ? 1 : 0;
    return "";
  }

  static std::string text_fault(const CardKey& key, const toml::node& node, CardValue& value) {
    std::string text;
    if (const auto given = node.value<std::string>()) {
      text = *given;
    } else if (const auto* const day = node.as_date();
               day != nullptr && key.type == CardType::date) {
      std::ostringstream out;
      out << day->get();
      text = out.str();
    } else {
      return key.type == CardType::choice ? choices_of(key) : "must be a text in quotes";
    }
    value.written = value.shown = text;
    if (text.find_first_not_of(" \t\r\n") == std::string::npos || text.size() > longest_text) {
      return fmt::format("must be a text of 1 to {} bytes", longest_text);
    }
    switch (key.type) {
      case CardType::choice:
        return std::ranges::find(key.choices, text) == key.choices.end() ? choices_of(key) : "";
      case CardType::date:
        return is_date(text)
                   ? ""
                   : "must be a day as 2026-11-30, or first and last, 2026-11-28/2026-11-30";
      case CardType::licence:
        return licence_fault(text);
      case CardType::preset: {
        const std::vector<std::string> names = files::preset_names();
        return std::ranges::find(names, text) != names.end()
                   ? ""
                   : fmt::format("is no built-in wire{}; `host-sim wires` lists them",
                                 files::did_you_mean(text, names));
      }
      default:
        return "";
    }
  }

  static std::string choices_of(const CardKey& key) {
    return fmt::format("must be one of: {}", fmt::join(key.choices, ", "));
  }

  static std::string licence_fault(const std::string& text) {
    const auto known = known_licences();
    if (std::ranges::find(known, text) != known.end() || is_own_licence(text)) {
      return "";
    }
    return fmt::format(
        "is not taken here{}; known are, as SPDX writes them: {}; another one is LicenseRef-NAME",
        files::did_you_mean(text, {known.begin(), known.end()}), fmt::join(known, ", "));
  }

  /// Whether the key belongs into this card; nothing where the key that decides is not there.
  std::optional<bool> applies(const CardKey& key) const {
    if (key.only.path.empty()) {
      return true;
    }
    const auto decides = card_.values.find(key.only.path);
    if (decides == card_.values.end()) {
      return std::nullopt;
    }
    return (decides->second.written == key.only.value) != key.only.is_not;
  }

  bool is_present(const CardKey& key) const { return present_.contains(key.path); }

  void check_presence() {
    std::vector<std::string> missing;
    for (const CardKey& key : card_keys()) {
      const std::optional<bool> applies_here = applies(key);
      if (applies_here == true && !is_present(key)) {
        missing.push_back(usual_spelling(key));
      }
      if (applies_here == false && is_present(key)) {
        faults_.push_back(fmt::format(R"({}: belongs only where {} is {}"{}"; {} is "{}")",
                                      present_.find(key.path)->second, key.only.path,
                                      key.only.is_not ? "not " : "", key.only.value, key.only.path,
                                      card_.word(key.only.path)));
      }
    }
    if (!missing.empty()) {
      faults_.push_back(
          fmt::format("{}: missing: {}; write \"{}\" for what you do not know, where that is "
                      "allowed: `host-sim record "
                      "--new-card` prints all keys and what they mean",
                      card_.origin, fmt::join(missing, ", "), unknown_word));
    }
  }

  /// What contradicts itself.
  void check_together() {
    const auto is_unknown = [&](std::string_view path) {
      const auto found = card_.values.find(path);
      return found != card_.values.end() && found->second.is_unknown;
    };
    if (is_unknown("wire.diameter") && is_unknown("wire.preset")) {
      faults_.push_back(
          fmt::format("{}: wire.diameter and wire.preset are both unknown; a replay needs one of "
                      "them",
                      card_.origin));
    }
    check_preset();
    const auto ohm = card_.number("wire.cold_resistance"), length_m = card_.number("wire.length"),
               diameter_m = card_.number("wire.diameter");
    // As the check `resistivity` of recordings.
    constexpr double low_ohm_m = 0.5e-6, high_ohm_m = 1.5e-6;
    if (ohm && length_m && diameter_m) {
      const double ohm_m = *ohm * std::numbers::pi * *diameter_m * *diameter_m / (4 * *length_m);
      if (ohm_m < low_ohm_m || ohm_m > high_ohm_m) {
        const CardValue& value = card_.values.find("wire.cold_resistance")->second;
        faults_.push_back(fmt::format(
            "{}: {} = {}: with this length and diameter it means {:.3g} uohm_m; NiTi has 0.5 to "
            "1.5: one of the three is wrong",
            card_.origin, value.key, value.written, 1e6 * ohm_m));
      }
    }
  }

  void check_preset() {
    const std::string preset = card_.word("wire.preset");
    const auto diameter_m = card_.number("wire.diameter");
    if (preset.empty() || preset == unknown_word || !diameter_m) {
      return;
    }
    constexpr double most = 0.05;
    const double preset_m = files::load_wire(preset).wire.geometry.diameter_m;
    if (std::abs(*diameter_m / preset_m - 1) > most) {
      faults_.push_back(fmt::format(
          "{}: {} = {}: {} has {:.4g} um; choose the wire of this diameter, or \"unknown\"",
          card_.origin, card_.values.find("wire.diameter")->second.key,
          card_.values.find("wire.diameter")->second.written, preset, 1e6 * preset_m));
    }
  }

  Card& card_;
  std::vector<std::string>& faults_;
  std::vector<std::pair<std::uint32_t, std::string>> found_;  ///< faults with their lines
  /// Where the file has a key, right or wrong, by its path.
  std::map<std::string_view, std::string> present_;
};

}  // namespace

std::optional<double> Card::number(std::string_view path) const {
  const auto found = values.find(path);
  return found == values.end() ? std::nullopt : found->second.si;
}

std::string Card::word(std::string_view path) const {
  const auto found = values.find(path);
  return found == values.end() ? "" : found->second.written;
}

Card parse_card(const std::string& text, const std::string& origin,
                std::vector<std::string>& faults) {
  Card card{origin, text, {}};
  try {
    const toml::table root = files::parse_toml(text, origin);
    CardReader(card, faults).read(root);
  } catch (const files::ConfigError& error) {
    faults.emplace_back(error.what());
  }
  return card;
}

Card load_card(const std::string& path) {
  std::vector<std::string> faults;
  Card card = parse_card(files::whole_file(path), path, faults);
  for (const std::string& fault : faults) {
    files::complain("host-sim", fault);
  }
  if (!faults.empty()) {
    throw files::UserError(fmt::format("{}: {} {} in the data card, named above", path,
                                       faults.size(), faults.size() == 1 ? "mistake" : "mistakes"));
  }
  return card;
}

}  // namespace smaservo::record
