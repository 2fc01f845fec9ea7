#include "firmware/daemon/bus/kept_settings.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <string_view>

#include "firmware/parameters/store/store.hpp"
#include "firmware/text/settings_text.hpp"
#include "hal/linux/system/file_store.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::daemon {
namespace {

static_assert(Storage<hal::FileStore>);

constexpr std::array<std::string_view, 6> slot_names{
    "valid", "empty", "unreadable", "damaged", "of a newer release", "refused"};

std::string_view name_of(const SlotReport& report) {
  return slot_names.at(static_cast<std::size_t>(report.state));
}

/// The values of the bad slot that differ from the settings in force, as far as they can still be
/// read.
std::vector<LostValue> lost_values(hal::FileStore& store, unsigned slot,
                                   const Settings<double>& in_force) {
  std::vector<LostValue> lost;
  salvage<double>(store, slot, [&](const ParameterRow<double>& row, Value value) {
    if (const Value now = row.get(in_force); now != value) {
      lost.push_back({row.key, value.bits, now.bits});
    }
  });
  return lost;
}

void say_outdated(const std::string& folder, const Loaded<double>& loaded, KeptSettings& kept) {
  const unsigned bad = 1 - loaded.slot;
  kept.said.push_back(fmt::format(
      "{}: slot {} is {}: what was stored last may be lost, and older settings are in force. The "
      "device cannot be armed before they are stored (1010h), or restored (1011h) and reset",
      folder, bad, name_of(loaded.slots.at(bad))));
  for (const LostValue& value : kept.lost) {
    const Parameter<double>& row = parameters<double>[find_parameter(value.key)];
    kept.said.push_back(fmt::format("{}: {} in force, {} in slot {}", row.path.text(),
                                    text::value_text(row, {value.in_force}),
                                    text::value_text(row, {value.stored}), bad));
  }
  if (kept.lost.empty()) {
    kept.said.push_back(
        fmt::format("no value that can still be read in slot {} differs from those in force", bad));
  }
}

}  // namespace

KeptSettings keep_settings(const std::string& folder, const Settings<double>& otherwise,
                           bool configured) {
  KeptSettings kept{otherwise, {}, {"settings as given, nothing is stored"}, {}};
  kept.faults.set(Fault::not_configured, !configured);
  if (folder.empty()) {
    return kept;
  }
  hal::FileStore store(folder);
  const Loaded<double> loaded = load_settings<double>(store);
  const auto& [a, b] = loaded.slots;
  if (loaded.reason == LoadReason::none) {
    if (a.state != SlotState::empty || b.state != SlotState::empty) {
      kept.faults.set(Fault::store_corrupt);
      kept.said = {fmt::format("{}: no stored settings could be read: slot 0 is {}, slot 1 is {}",
                               folder, name_of(a), name_of(b))};
    }
    return kept;
  }
  kept.settings = loaded.settings;
  kept.faults.set(Fault::not_configured, false);
  kept.said = {fmt::format("settings from {}, slot {}, number {}; the other slot is {}", folder,
                           loaded.slot, loaded.slots.at(loaded.slot).sequence,
                           name_of(loaded.slots.at(1 - loaded.slot)))};
  if (loaded.may_be_older) {
    kept.faults.set(Fault::store_outdated);
    kept.lost = lost_values(store, 1 - loaded.slot, kept.settings);
    say_outdated(folder, loaded, kept);
  }
  return kept;
}

bool has_settings(const std::string& folder) {
  hal::FileStore store(folder);
  return !folder.empty() && load_settings<double>(store).reason != LoadReason::none;
}

std::string store_settings(const std::string& folder, const Settings<double>& settings) {
  hal::FileStore store(folder);
  const Saved saved = save_settings(store, settings);
  constexpr std::array<std::string_view, 7> problems{"",
                                                     "the settings contradict each other",
                                                     "erasing fails",
                                                     "writing fails",
                                                     "making it durable fails",
                                                     "reading back fails",
                                                     "it keeps something else"};
  return std::string(problems.at(static_cast<std::size_t>(saved.problem)));
}

std::string forget_settings(const std::string& folder) {
  for (unsigned slot = 0; slot < slot_count; ++slot) {
    std::error_code error;
    std::filesystem::remove(fmt::format("{}/settings.{}", folder, slot), error);
    if (error) {
      return error.message();
    }
  }
  return files::sync_folder_of(folder + "/settings.0")
             ? ""
             : fmt::format("{}: a loss of power may bring the store back: {}", folder,
                           std::strerror(errno));
}

}  // namespace smaservo::daemon
