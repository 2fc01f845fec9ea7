#pragma once
// All faults in one table, in the order of Fault, checked when it is compiled.

#include <algorithm>
#include <array>

#include "firmware/safety/faults/drive.hpp"
#include "firmware/safety/faults/estimate.hpp"
#include "firmware/safety/faults/machine.hpp"
#include "firmware/safety/faults/wire.hpp"

namespace smaservo {

inline constexpr auto fault_rows = [] {
  std::array<FaultRow, fault_count - 1> rows{};
  std::size_t n = 0;
  const auto add = [&](const auto& part) {
    for (const FaultRow& row : part) {
      rows.at(n++) = row;
    }
  };
  add(drive_faults);
  add(wire_faults);
  add(estimate_faults);
  add(machine_faults);
  std::ranges::sort(rows, {}, &FaultRow::fault);
  return rows;
}();

/// The row of a fault; not for Fault::none.
constexpr const FaultRow& fault_row(Fault fault) {
  return fault_rows[static_cast<std::size_t>(fault) - 1];
}

/// The fault's name, such as "wire_open"; "none" for Fault::none.
constexpr std::string_view fault_name(Fault fault) {
  return fault == Fault::none ? "none" : fault_row(fault).name;
}

/// All faults for whose row `like` is true.
template <class Like>
constexpr FaultSet faults_where(Like like) {
  FaultSet set;
  for (const FaultRow& row : fault_rows) {
    set.add(row.fault, like(row));
  }
  return set;
}
constexpr FaultSet faults_of(FaultClass severity) {
  return faults_where([&](const FaultRow& row) { return row.severity == severity; });
}

constexpr std::string_view class_name(FaultClass severity) {
  constexpr std::array<std::string_view, fault_class_count> names{"F0", "F1", "F2", "L", "B", "W"};
  return names[static_cast<std::size_t>(severity)];
}

/// The setting that gives the time that a condition has to last; empty for most faults, whose time
/// is in their row.
constexpr std::string_view time_setting(Fault fault) {
  switch (fault) {
    case Fault::following_error:
      return "trips.following_s";
    case Fault::sample_stale:
      return "timing.sample_timeout_s";
    case Fault::command_timeout:
      return "timing.command_timeout_s";
    default:
      return {};
  }
}

static_assert(
    [] {
      for (std::size_t i = 0; i < fault_rows.size(); ++i) {
        if (fault_rows[i].fault != static_cast<Fault>(i + 1)) {
          return false;
        }
      }
      return true;
    }(),
    "a row for each fault, in their order");
static_assert(std::ranges::all_of(fault_rows,
                                  [](const FaultRow& r) {
                                    return !r.name.empty() && !r.causes.empty() &&
                                           !r.check.empty() && r.text.ends_with('.') &&
                                           r.deglitch_s >= 0 && r.deglitch_s <= 5;
                                  }),
              "every row is filled");
static_assert(
    [] {
      for (const FaultRow& a : fault_rows) {
        for (const FaultRow& b : fault_rows) {
          if (a.fault < b.fault && (a.code == b.code || a.name == b.name)) {
            return false;
          }
        }
      }
      return true;
    }(),
    "codes and names are unique");
static_assert(std::ranges::all_of(fault_rows,
                                  [](const FaultRow& r) {
                                    const bool trips = r.severity <= FaultClass::F2;
                                    return trips == (r.clears == Clears::command);
                                  }),
              "what trips is latched until it is cleared, nothing else is");

}  // namespace smaservo
