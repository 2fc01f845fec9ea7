#include "host-sim/record/check.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <optional>

#include "host-sim/record/card/card.hpp"
#include "host-sim/record/card/wire_of_card.hpp"
#include "host-sim/record/contents.hpp"
#include "host-sim/record/folder.hpp"
#include "host-sim/record/run.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/toml/toml_fields.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::record {

namespace fs = std::filesystem;

namespace {

class Inspection {
 public:
  Inspection(const std::string& path, const std::vector<std::string>& allowed)
      : path_(path), allowed_(allowed), contents_(contents_of(path)) {}

  Checked run() {
    checked_.faults = contents_.faults;
    checked_.notes = contents_.notes;
    if (!contents_.readme_fault.empty()) {
      checked_.faults.push_back(contents_.readme_fault);
    }
    attempt([&] { check_card(); });
    attempt([&] { check_wire(); });
    for (const std::string& name : contents_.files) {
      if (is_run(name)) {
        refuse_after_signal(path_.string());
        attempt([&] { check_run(name); });
      }
    }
    if (checked_.runs == 0) {
      fault(runs_name, "has no run, which is a file NAME.csv");
    }
    return std::move(checked_);
  }

 private:
  /// What cannot be read is a fault, and the rest is looked at all the same.
  void attempt(const std::function<void()>& look) {
    try {
      look();
    } catch (const files::Error& error) {
      checked_.faults.emplace_back(error.what());
    }
  }
  std::string shown(const std::string& name) const { return (path_ / name).string(); }
  void fault(const std::string& name, const std::string& what) {
    checked_.faults.push_back(fmt::format("{}: {}", shown(name), what));
  }
  void note(const std::string& name, const std::string& what) {
    checked_.notes.push_back(fmt::format("{}: {}", shown(name), what));
  }

  bool has(const char* name) const { return contents_.files.contains(name); }

  void check_card() {
    if (!has(card_name)) {
      return;
    }
    const std::size_t before = checked_.faults.size();
    Card card = parse_card(files::whole_file(shown(card_name)), shown(card_name), checked_.faults);
    if (checked_.faults.size() == before) {
      card_ = std::move(card);
    }
  }

  /// The wire must be whole, and the card's.
  void check_wire() {
    if (!has(wire_name)) {
      return;
    }
    const std::string text = files::whole_file(shown(wire_name));
    if (files::parse_toml(text, shown(wire_name)).contains("based_on")) {
      fault(wire_name, "has based_on, so it depends on other files; it must have all parameters");
      return;
    }
    wire_ = files::parse_wire(text, shown(wire_name));
    if (!card_) {
      return;
    }
    const Card& card = *card_;
    const Wire<double>& wire = wire_->wire;
    const bool length = compare(card, "wire.length", wire.geometry.length_m, "m"),
               diameter = compare(card, "wire.diameter", wire.geometry.diameter_m, "m"),
               ohm = compare(card, "wire.cold_resistance", cold_resistance_ohm(wire), "ohm");
    if (length && diameter && ohm && files::to_toml(wire_of(card)) != text) {
      note(wire_name,
           "differs from what this version of host-sim makes of the card: its presets are others, "
           "or somebody has changed it");
    }
  }

  bool compare(const Card& card, const char* key, double has, const char* unit) {
    const std::optional<double> said = card.number(key);
    if (!said || std::abs(has - *said) <= 1e-6 * *said) {
      return true;
    }
    fault(wire_name, fmt::format("{} is {:.9g} {}, and {} has {:.9g} {}", key, has, unit, card_name,
                                 *said, unit));
    return false;
  }

  void check_run(const std::string& name) {
    ++checked_.runs;
    if (const std::string wrong = name_fault(run_of(name)); !wrong.empty()) {
      fault(name, fmt::format("the name of a run {}", wrong));
    }
    if (const std::string wrong = fault_of(shown(name), card_.value_or(Card{})); !wrong.empty()) {
      checked_.faults.push_back(wrong);
      return;
    }
    if (!wire_) {
      return;
    }
    const inspect::Facts facts = facts_of(shown(name), *wire_);
    checked_.rows += facts.rows;
    if (const std::string wrong = load_fault(facts, card_.value_or(Card{}), *wire_);
        !wrong.empty()) {
      fault(name, wrong);
    }
    if (const std::string text = rate_note(facts, card_.value_or(Card{})); !text.empty()) {
      note(name, text);
    }
    for (const checks::Finding& finding : facts.findings) {
      const bool is_allowed = std::ranges::find(allowed_, finding.check) != allowed_.end();
      if (finding.is_error && !is_allowed) {
        fault(name,
              fmt::format("{} (to take it for a note: --allow {})", finding.text, finding.check));
      } else {
        note(name, finding.text);
      }
    }
  }

  fs::path path_;
  const std::vector<std::string>& allowed_;
  const Contents contents_;
  Checked checked_;
  std::optional<Card> card_;
  std::optional<files::WireDescription> wire_;
};

}  // namespace

Checked check_folder(const std::string& path, const std::vector<std::string>& allowed) {
  check_allowed(allowed);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::is_directory(status)) {
    throw files::UserError(
        fmt::format("--check {}: {}", path,
                    !fs::exists(status) ? "there is no such folder" : "is a file and no folder"));
  }
  return Inspection(path, allowed).run();
}

}  // namespace smaservo::record
