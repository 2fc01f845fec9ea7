#include "host-sim/can/status.hpp"

#include <fmt/format.h>

#include "firmware/safety/standing.hpp"
#include "firmware/text/canopen/change_text.hpp"
#include "firmware/text/device_names.hpp"
#include "host-sim/can/positions.hpp"
#include "host-sim/can/shown.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::can {
namespace {

FaultSet fault_set(Remote& remote, const std::string& name) {
  return FaultSet::from_bits(remote.whole("faults." + name + "_low") |
                             static_cast<std::uint64_t>(remote.whole("faults." + name + "_high"))
                                 << 32U);
}

std::string or_none(const std::string& text) {
  return text.empty() ? "none" : text;
}

/// Each warning since the start, with the number of times; "not counted" for nodes of older
/// releases.
std::string warning_counts_text(Remote& remote) {
  std::string text;
  try {
    for_each_fault(warning_faults, [&](Fault fault) {
      const auto count = remote.whole(fmt::format("warnings.{}", fault_name(fault)));
      if (count != 0) {
        text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", fault_name(fault),
                            count == 1 ? "once" : fmt::format("{} times", count));
      }
    });
  } catch (const SdoError& error) {
    if (error.code() != static_cast<std::uint32_t>(canopen::Abort::no_object)) {
      throw;
    }
    return "not counted by this node's release";
  }
  return text;
}

std::string device_state(Remote& remote) {
  const auto state = remote.whole("device.state");
  return state < device_state_count ? std::string(text::state_name(static_cast<DeviceState>(state)))
                                    : fmt::format("{}", state);
}

}  // namespace

std::string info_text(Remote& remote, Units units) {
  files::TextTable table({{""}, {""}});
  table.add({"node", fmt::format("{} on {}", remote.node(), remote.bus().name())});
  table.add({"device", fmt::format("{}, hardware {}, software {}", remote.text("1008"),
                                   remote.text("1009"), remote.text("100A"))});
  table.add({"identity", fmt::format("vendor {}, product {}, revision {}, serial number {}",
                                     remote.text("1018:1"), remote.text("1018:2"),
                                     remote.text("1018:3"), remote.number("1018:4"))});
  const auto status = remote.whole("6041");
  table.add({"drive", fmt::format("{} ({:04X}h), mode {}", drive_state_text(status), status,
                                  remote.text("6061"))});
  table.add({"wire", device_state(remote)});
  table.add({"position", fmt::format("{}, target {}", position_text(remote.number("6064"), units),
                                     position_text(remote.number("607A"), units))});
  const Unit degree = unit_in(kind::temperature, units);
  table.add({"temperature",
             fmt::format("{:.1f} {}", degree.from_si(remote.number("live.wire_temperature_K")),
                         degree.suffix)});
  table.add({"faults", or_none(text::names_of(latched_faults(remote)))});
  table.add(
      {"loop", fmt::format("{} steps, {} missed, {:.3f} ms late at most, {:.3f} ms busy at most",
                           remote.text("loop.steps"), remote.text("loop.missed"),
                           1e3 * remote.number("loop.max_late_s"),
                           1e3 * remote.number("loop.max_busy_s"))});
  table.add({"bus", fmt::format("{} frames dropped, {} times off, {} times a full queue",
                                remote.text("bus.dropped"), remote.text("bus.off"),
                                remote.text("bus.queue_full"))});
  table.add({"PDOs", fmt::format("{:.0f} frames/s at most, {:.1f} % of the bit rate",
                                 remote.number("bus.pdo_frames_per_s"),
                                 remote.number("bus.pdo_load_percent"))});
  table.add({"access", fmt::format("level {}", remote.text("access.level"))});
  return table.text();
}

std::string changes_text(Remote& remote) {
  constexpr std::size_t size = canopen::ChangeLog::bytes;
  const Bytes log = remote.read(text::find_object("changes.last"));
  std::string text;
  for (std::size_t end = log.size() / size * size; end != 0; end -= size) {
    const canopen::LoggedChange change = text::change_of(std::span(log).subspan(end - size, size));
    text += fmt::format("{:>12.3f} s  {}\n", 1e-3 * static_cast<double>(change.time_ms),
                        text::change_text(change));
  }
  return text.empty() ? "none\n" : text;
}

FaultSet latched_faults(Remote& remote) {
  return fault_set(remote, "latched");
}

Fault first_cause(Remote& remote) {
  const auto number = remote.whole("faults.first_cause");
  return number < fault_count ? static_cast<Fault>(number) : Fault::none;
}

std::string faults_text(Remote& remote) {
  files::TextTable table({{""}, {""}});
  table.add({"state", device_state(remote)});
  table.add({"latched", or_none(text::names_of(latched_faults(remote)))});
  const Fault first = first_cause(remote);
  if (first != Fault::none) {
    table.add({"first cause", std::string(fault_name(first))});
  }
  table.add({"active", or_none(text::names_of(fault_set(remote, "active")))});
  table.add({"warnings", or_none(text::names_of(fault_set(remote, "warnings")))});
  table.add({"warnings since the start", or_none(warning_counts_text(remote))});
  table.add({"blocked by", or_none(text::names_of(fault_set(remote, "blocks")))});
  const auto reasons = remote.whole("device.limit_reasons");
  table.add({"limited by", or_none(text::limit_reason_names(reasons))});
  const auto count = remote.whole("1003:0");
  for (unsigned i = 1; i <= count; ++i) {
    const auto entry = remote.whole(fmt::format("1003:{}", i));
    table.add({i == 1 ? "history" : "", fmt::format("{:04X}h", entry & 0xFFFFU)});
  }
  return table.text();
}

}  // namespace smaservo::can
