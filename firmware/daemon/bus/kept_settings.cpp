#include "firmware/daemon/bus/kept_settings.hpp"

#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <string_view>

#include "firmware/parameters/store/store.hpp"
#include "hal/linux/system/file_store.hpp"

namespace smaservo::daemon {
namespace {

static_assert(Storage<hal::FileStore>);

constexpr std::array<std::string_view, 6> slot_names{
    "valid", "empty", "unreadable", "damaged", "of a newer release", "refused"};

std::string_view name_of(const SlotReport& report) {
  return slot_names.at(static_cast<std::size_t>(report.state));
}

}  // namespace

KeptSettings keep_settings(const std::string& folder, const Settings<double>& otherwise,
                           bool configured) {
  KeptSettings kept{otherwise, {}, "settings as given, nothing is stored"};
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
      kept.said = fmt::format("{}: no stored settings could be read: slot 0 is {}, slot 1 is {}",
                              folder, name_of(a), name_of(b));
    }
    return kept;
  }
  kept.settings = loaded.settings;
  kept.faults.set(Fault::not_configured, false);
  kept.said =
      fmt::format("settings from {}, slot {}, number {}; the other slot is {}", folder, loaded.slot,
                  loaded.slots.at(loaded.slot).sequence, name_of(loaded.slots.at(1 - loaded.slot)));
  return kept;
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
  return {};
}

}  // namespace smaservo::daemon
