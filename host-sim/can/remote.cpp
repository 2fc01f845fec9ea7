#include "host-sim/can/remote.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "firmware/text/device_names.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::can {
namespace {

// Statusword.
constexpr unsigned state_mask = 0x6F;
constexpr unsigned fault_mask = 0x4F;
constexpr unsigned fault_state = 0x08;
constexpr unsigned enabled_state = 0x27;
constexpr unsigned reached_bit = 0x400;
constexpr unsigned acknowledged_bit = 0x1000;

// Controlword.
constexpr unsigned shutdown = 0x06;
constexpr unsigned switch_on = 0x07;
constexpr unsigned enable_operation = 0x0F;
constexpr unsigned new_setpoint_at_once = 0x30;
constexpr unsigned fault_reset = 0x80;

constexpr double state_patience_s = 3;
constexpr std::int64_t listen_us = 10'000;

struct StateName {
  unsigned bits, mask;
  const char* name;
};
constexpr auto drive_states = std::to_array<StateName>({
    {0x00, 0x4F, "Not ready to switch on"},
    {0x40, 0x4F, "Switch on disabled"},
    {0x21, 0x6F, "Ready to switch on"},
    {0x23, 0x6F, "Switched on"},
    {0x27, 0x6F, "Operation enabled"},
    {0x07, 0x6F, "Quick stop active"},
    {0x0F, 0x4F, "Fault reaction active"},
    {0x08, 0x4F, "Fault"},
});

/// A hint to append to the node's refusal: the allowed values, or what to do.
std::string hint(const text::KnownObject& object, std::uint32_t code) {
  const std::string allowed = text::allowed_text(object);
  switch (code) {
    case 0x06090030:
    case 0x06090031:
    case 0x06090032:
      return allowed.empty() ? "" : fmt::format("; must be {}", allowed);
    case 0x08000021:
      return "; --key gives the key of the access level";
    case 0x08000022:
      return object.parameter != nullptr &&
                     object.parameter->change == smaservo::Change::without_current
                 ? "; it may change only while not enabled: `host-sim can disable`"
                 : "";
    default:
      return "";
  }
}

}  // namespace

std::string nmt_state_text(unsigned state) {
  switch (state) {
    case 0x00:
      return "boot-up";
    case 0x04:
      return "stopped";
    case 0x05:
      return "operational";
    case 0x7F:
      return "pre-operational";
    default:
      return fmt::format("unknown state {:02X}h", state);
  }
}

std::string drive_state_text(unsigned statusword) {
  const auto* const found = std::ranges::find_if(
      drive_states, [&](const StateName& s) { return (statusword & s.mask) == s.bits; });
  return found == drive_states.end() ? fmt::format("unknown state {:04X}h", statusword)
                                     : found->name;
}

Bytes Remote::read(const text::KnownObject& object) {
  try {
    // The value of a domain may be long.
    return canopen::size_of(object.type) == 0 && object.type == canopen::Type::domain
               ? client_.upload_block(object.key)
               : client_.upload(object.key);
  } catch (const SdoError& error) {
    if (object.name.empty()) {
      throw;
    }
    throw SdoError(fmt::format("{}: {}", object.name, error.what()), error.code());
  }
}

void Remote::write(const text::KnownObject& object, const Bytes& value, Write how) {
  try {
    if (how == Write::again) {
      client_.download_again(object.key, value);
    } else {
      client_.download(object.key, value);
    }
  } catch (const SdoError& error) {
    throw SdoError(
        fmt::format("{} = {}: {}{}", text::title(object), text::value_text(object, value),
                    error.what(), hint(object, error.code())),
        error.code());
  }
}

std::string Remote::text(const std::string& name) {
  const text::KnownObject object = text::find_object(name);
  return text::value_text(object, read(object));
}

double Remote::number(const std::string& name) {
  const text::KnownObject object = text::find_object(name);
  return text::value_number(object, read(object));
}

std::uint32_t Remote::whole(const std::string& name) {
  const double value = number(name);
  if (!(value >= 0 && value <= std::numeric_limits<std::uint32_t>::max()) ||
      value != std::floor(value)) {
    throw files::UserError(fmt::format(
        "node {}: {}: the answer must be a whole number from 0 to {} in the object's own type: is "
        "this a smaservo of this version?",
        node(), text::title(text::find_object(name)), std::numeric_limits<std::uint32_t>::max()));
  }
  return static_cast<std::uint32_t>(value);
}

void Remote::set(const std::string& name, const std::string& value, Write how) {
  const text::KnownObject object = text::find_object(name);
  write(object, text::value_bytes(object, value), how);
}

void Remote::change(const std::vector<Change>& changes) {
  const bool as_set = changes.size() > 1 && std::ranges::all_of(changes, [](const Change& change) {
                        return change.first.parameter != nullptr;
                      });
  if (as_set) {
    stage(changes, "3");
    return;
  }
  for (const auto& [object, value] : changes) {
    write(object, value);
  }
}

/// `command` is "3" for commit or "2" for try.
void Remote::stage(const std::vector<Change>& changes, const char* command) {
  set("tuning.command", "1");
  try {
    for (const auto& [object, value] : changes) {
      write(object, value);
    }
    try {
      set("tuning.command", command);
    } catch (const SdoError& error) {
      explain_refusal(error);
    }
  } catch (...) {
    revert();
    throw;
  }
}

void Remote::try_for(const std::vector<Change>& changes, double seconds, Client client) {
  set("tuning.trial_s", fmt::format("{}", seconds));
  stage(changes, client == Client::leaves ? "5" : "2");
}

void Remote::keep_trial() {
  try {
    set("tuning.command", "3");
  } catch (const SdoError& error) {
    explain_refusal(error);
  }
}

void Remote::revert_trial() {
  set("tuning.command", "4");
}

/// Takes the staged changes of a set back. If the node does not answer, it takes them back by
/// itself after a time.
void Remote::revert() {
  try {
    set("tuning.command", "4");
  } catch (const files::UserError& error) {
    files::complain("host-sim", error.what());
  }
}

/// Prints which parameters of a refused set contradict each other.
void Remote::explain_refusal(const SdoError& error) {
  const auto named = [&](const char* object) {
    const auto bits = whole(object);
    return text::find_object(fmt::format("{:04X}:{}", bits >> 16U, bits >> 8U & 0xFFU));
  };
  const text::KnownObject one = named("tuning.refused");
  const text::KnownObject other = named("tuning.refused_other");
  if (one.key.index == 0) {
    throw error;
  }
  throw files::UserError(fmt::format(
      "nothing has changed: {} = {} {}", text::title(one), text::value_text(one, read(one)),
      other.key.index == 0 ? fmt::format("is refused: {}", error.what())
                           : fmt::format("contradicts {} = {}", text::title(other),
                                         text::value_text(other, read(other)))));
}

void Remote::nmt(NmtCommand command) {
  bus().send({.id = 0,
              .length = 2,
              .data = {static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(node())}});
}

bool Remote::wait_for(const std::function<bool(unsigned)>& reached, double patience_s) {
  const std::int64_t until_us = bus().now_us() + static_cast<std::int64_t>(patience_s * 1e6);
  for (;;) {
    if (reached(status())) {
      return true;
    }
    renew();
    const std::int64_t now_us = bus().now_us();
    if (now_us >= until_us) {
      return false;
    }
    hal::CanFrame passing;
    while (bus().receive(passing, now_us + listen_us)) {
    }
  }
}

std::string Remote::reasons() {
  const auto set_of = [&](const char* low, const char* high) {
    return FaultSet::from_bits(whole(low) | static_cast<std::uint64_t>(whole(high)) << 32U);
  };
  const FaultSet all = set_of("faults.blocks_low", "faults.blocks_high") |
                       set_of("faults.latched_low", "faults.latched_high");
  return all.empty() ? ""
                     : fmt::format(": {}; `host-sim can faults` says more", text::names_of(all));
}

void Remote::enable() {
  if ((status() & fault_mask) == fault_state) {
    throw files::UserError(fmt::format(
        "node {} has a fault{}; `host-sim can reset-faults` acknowledges it", node(), reasons()));
  }
  if ((status() & state_mask) == enabled_state) {
    return;
  }
  nmt(NmtCommand::start);
  const std::pair<unsigned, unsigned> steps[] = {
      {shutdown, 0x21}, {switch_on, 0x23}, {enable_operation, enabled_state}};
  for (const auto& [word, state] : steps) {
    control(word);
    const auto reached = [expected = state](unsigned status) {
      return (status & state_mask) == expected;
    };
    if (!wait_for(reached, state_patience_s)) {
      throw files::UserError(
          fmt::format("node {} stays in \"{}\"{}", node(), drive_state_text(status()), reasons()));
    }
  }
}

void Remote::disable() {
  control(0);
  const auto off = [](unsigned status) { return (status & state_mask) != enabled_state; };
  if (!wait_for(off, state_patience_s)) {
    throw files::UserError(
        fmt::format("node {} stays in \"{}\"", node(), drive_state_text(status())));
  }
}

void Remote::reset_faults() {
  control(0);
  control(fault_reset);
  const auto gone = [](unsigned status) { return (status & fault_mask) != fault_state; };
  if (!wait_for(gone, state_patience_s)) {
    throw files::UserError(fmt::format("node {}: the fault stays{}", node(), reasons()));
  }
  control(0);
}

void Remote::set_mode(int mode) {
  set("6060", std::to_string(mode));
  // The mode is in force when 6061h (mode of operation display) shows it.
  const auto shown = [&](unsigned) { return number("6061") == mode; };
  if (!wait_for(shown, state_patience_s)) {
    throw files::UserError(fmt::format("node {} does not change to mode {}", node(), mode));
  }
}

void Remote::start_move(std::int32_t target_um) {
  set("607A", std::to_string(target_um));
  control(enable_operation);
  control(enable_operation | new_setpoint_at_once);
  const auto taken = [](unsigned status) { return (status & acknowledged_bit) != 0; };
  if (!wait_for(taken, state_patience_s)) {
    throw files::UserError(fmt::format("node {} does not take the set-point{}", node(), reasons()));
  }
  control(enable_operation);
}

void Remote::move(std::int32_t target_um, double patience_s) {
  if ((status() & state_mask) != enabled_state) {
    throw files::UserError(
        fmt::format("node {} is not enabled: `host-sim can enable` first", node()));
  }
  set_profile_position();
  start_move(target_um);
  const auto there = [](unsigned status) {
    return (status & reached_bit) != 0 || (status & state_mask) != enabled_state;
  };
  const bool ended = wait_for(there, patience_s);
  if (!ended || (status() & state_mask) != enabled_state) {
    throw files::UserError(
        fmt::format("node {} has not reached {} um within {} s: it is at {} um, \"{}\"{}", node(),
                    target_um, patience_s, text("6064"), drive_state_text(status()), reasons()));
  }
}

void Remote::renew() {
  const std::int64_t now_us = bus().now_us();
  if (now_us - renewed_us_ < renewal_us) {
    return;
  }
  renewed_us_ = now_us;
  control(whole("6040"));
}

void Remote::hold(double for_s) {
  const std::int64_t until_us = bus().now_us() + static_cast<std::int64_t>(for_s * 1e6);
  const auto word = whole("6040");
  while (bus().now_us() < until_us) {
    if ((status() & state_mask) != enabled_state) {
      throw files::UserError(fmt::format("node {} is not enabled: \"{}\"{}", node(),
                                         drive_state_text(status()), reasons()));
    }
    if (whole("6040") != word) {
      throw files::UserError(fmt::format(
          "node {} is commanded by somebody else: its controlword has changed", node()));
    }
    renew();
    hal::CanFrame passing;
    const std::int64_t next_us = std::min(bus().now_us() + listen_us, until_us);
    while (bus().receive(passing, next_us)) {
    }
  }
}

void Remote::store() {
  Remote patient = *this;
  patient.client_.set_timeout(std::max(client_.timeout_us(), SdoClient::store_timeout_us));
  patient.write(text::find_object("1010:1"), {'s', 'a', 'v', 'e'});
}

}  // namespace smaservo::can
