#include "firmware/canopen/servo/servo_core.hpp"

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/servo/duration.hpp"
#include "firmware/safety/failsafe.hpp"

namespace smaservo::canopen {
namespace {

constexpr const ObjectRows& drive_rows = without_texts<drive_object_rows>;

// Ranges of an entry's handle: below parameter_handle an object of the drive, from parameter_handle
// on a parameter, from signal_handle on a signal.
constexpr std::uint16_t parameter_handle = 0x4000;
constexpr std::uint16_t signal_handle = 0x8000;

constexpr Key access_key{0x2003, 2}, tuning_key{0x2102, 1}, log_key{0x2220, 2},
    recorder_key{0x2300, 1}, data_key{0x2300, 11}, step_key{0x2400, 1};
constexpr Key node_id_key{0x2000, 2};

constexpr auto fault_codes = [] {
  std::array<std::uint16_t, fault_count> codes{};
  for (const FaultRow& row : fault_rows) {
    codes[static_cast<std::size_t>(row.fault)] = row.code;
  }
  return codes;
}();
std::uint16_t code_of(Fault fault) {
  return fault_codes[static_cast<std::size_t>(fault)];
}

/// The bits of 1001h for an EMCY code.
std::uint8_t register_of(std::uint16_t code) {
  constexpr unsigned generic = 1, current = 2, voltage = 4, temperature = 8, bus = 0x10,
                     manufacturer = 0x80;
  switch (code >> 12U) {
    case 0x2:
      return generic | current;
    case 0x3:
      return generic | voltage;
    case 0x4:
      return generic | temperature;
    case 0x8:
      return (code & 0xF00U) == 0x100 || (code & 0xF00U) == 0x200 ? generic | bus : generic;
    case 0xF:
      return generic | manufacturer;
    default:
      return generic;
  }
}

}  // namespace

std::byte* ServoCore::memory() {
  // The table's offsets are those of this struct, which is plain.
  return reinterpret_cast<std::byte*>(&objects_);  // NOLINT(*-reinterpret-cast)
}

ObjectTable ServoCore::table() {
  return {drive_rows, {memory(), sizeof objects_}};
}

// Objects.

Abort ServoCore::find(Key key, Entry& entry) const {
  if (key.index == live_values) {
    if (key.sub == 0) {
      entry = highest_sub_entry(key, signal_count);
    } else {
      entry = {key, Type::real, readable | in_tpdo,
               static_cast<std::uint16_t>(signal_handle + key.sub - 1U), 4};
    }
    return key.sub <= signal_count ? Abort::none : Abort::no_sub;
  }
  const Abort found = find_object(drive_rows, key, entry);
  if (found != Abort::no_object) {
    entry.size = key == log_key && found == Abort::none
                     ? log_.kept() * static_cast<std::uint32_t>(ChangeLog::bytes)
                 : key == data_key && found == Abort::none ? recorder_.size()
                                                           : entry.size;
    return found;
  }
  const Abort parameter = parameters_.find(key, entry);
  if (parameter == Abort::none && !is_highest_sub(entry)) {
    entry.handle = static_cast<std::uint16_t>(entry.handle + parameter_handle);
  }
  return parameter;
}

Abort ServoCore::read(const Entry& entry, std::uint32_t offset, std::span<std::uint8_t> to) {
  if (is_highest_sub(entry)) {
    put_number(to, entry.handle & 0xFFU);
  } else if (signal_handle <= entry.handle) {
    put_number(to, as_bits(signals_[static_cast<std::size_t>(entry.handle - signal_handle)]));
  } else if (parameter_handle <= entry.handle) {
    put_number(to, parameters_.read(static_cast<std::uint16_t>(entry.handle - parameter_handle)));
  } else if (entry.key == log_key) {
    log_.read(offset, to);
  } else if (entry.key == data_key) {
    return recorder_.read(offset, to);
  } else {
    const Object object = drive_rows[entry.handle];
    put_number(to, object.at == nowhere ? object.standard
                                        : load(object, std::as_bytes(std::span(&objects_, 1))));
  }
  return Abort::none;
}

Abort ServoCore::write(const Entry& entry, std::span<const std::uint8_t> from, Source source) {
  const std::uint32_t value = take_value(entry.type, from);
  return parameter_handle <= entry.handle ? write_parameter(entry, value, source)
                                          : write_object(entry, value, source);
}

Abort ServoCore::write_object(const Entry& entry, std::uint32_t value, Source source) {
  const Object object = drive_rows[entry.handle];
  const bool is_command = object.at == nowhere;
  const std::uint32_t before = entry.key == tuning_key ? objects_.tuning_state
                               : is_command            ? 0
                                            : load(object, std::as_bytes(std::span(&objects_, 1)));
  Abort result = may_write(level_of(object.access))
                     ? check_range(object.type, value, object.min, object.max)
                     : Abort::local;
  result = result == Abort::none ? check(entry.key, value) : result;
  result = result == Abort::none && is_command ? run(entry.key, value) : result;
  if (result != Abort::none) {
    log(entry.key, before, value, source, result);
    return result;
  }
  if ((object.access & in_rpdo) != 0 || entry.key == step_key) {
    command_watch_.commanded(now_us_, source);
  }
  if (is_command) {
    return result;
  }
  keep(object, {memory(), sizeof objects_}, value);
  setpoints_ += axis_.follows(entry.key) ? 1U : 0U;
  if (axis_.follows(entry.key) && value != before) {
    axis_.new_cyclic_setpoint();
  }
  if (entry.key.index == index::controlword) {
    axis_.controlword(static_cast<std::uint16_t>(before), static_cast<std::uint16_t>(value));
  }
  // A PDO repeats its values in each cycle: only a changed value counts.
  if ((object.access & stored) != 0 && (source != Source::rpdo || value != before)) {
    node_.touch();
    log(entry.key, before, value, source, result);
  }
  return result;
}

Abort ServoCore::check(Key key, std::uint32_t value) const {
  const auto number = static_cast<std::int32_t>(value);
  if (key.index == index::mode) {
    // The negative modes set the power without a loop of the device.
    return number < 0 && !may_write(Level::tune) ? Abort::local : axis_.check_mode(number);
  }
  if (key.index == 0x2301 || key == Key{0x2300, 5}) {
    return Recorder::check_channel(value);
  }
  if (key.index == index::position_limit && key.sub != 0) {
    auto limit = objects_.position_limit;
    limit[key.sub - 1U] = number;
    return limit[1] < limit[0] ? Abort::max_below_min : Abort::none;
  }
  return Axis::check_option(key.index, number);
}

/// Carries out a write to an object that is a command.
Abort ServoCore::run(Key key, std::uint32_t value) {
  const auto command = static_cast<std::uint8_t>(value);
  if (key == access_key) {
    unlock(value);
    return Abort::none;
  }
  if (key == tuning_key) {
    return tune(static_cast<TuningCommand>(command));
  }
  if (key == recorder_key) {
    return recorder_.command(command);
  }
  return step_test_.command(command, axis_, recorder_);
}

void ServoCore::unlock(std::uint32_t key) {
  const AccessKeys& keys = config_.keys;
  const Level level = keys.set_up == 0 || key == keys.set_up ? Level::set_up
                      : keys.tune == 0 || key == keys.tune   ? Level::tune
                                                             : Level::operate;
  objects_.level = static_cast<std::uint8_t>(level);
}

// Parameters.

Abort ServoCore::write_parameter(const Entry& entry, std::uint32_t value, Source source) {
  const auto row = static_cast<std::uint16_t>(entry.handle - parameter_handle);
  const std::uint32_t before = parameters_.read(row);
  Abort result = Abort::none;
  if (!may_write(parameters_.level(row))) {
    result = Abort::local;
  } else if (!parameters_.has_room()) {
    result = Abort::transfer;
  } else if (entry.type == Type::real && ceiling_of(config_.ceilings, entry.key) < as_real(value)) {
    result = Abort::too_high;
  } else {
    result = parameters_.write(row, value, axis_.may_heat());
  }
  log(entry.key, before, value, source, result);
  if (result == Abort::none) {
    node_.touch();
    if (entry.key == node_id_key) {
      node_.forget_lss_node_id();
    }
  }
  show_tuning();
  return result;
}

Abort ServoCore::tune(TuningCommand command) {
  if (!parameters_.has_room()) {
    return Abort::transfer;
  }
  const Abort result = parameters_.tune(command, objects_.trial_s, axis_.may_heat());
  tuned_us_ = now_us_;
  if (result == Abort::none) {
    left_alone_ = command == TuningCommand::leave;
    log(tuning_key, objects_.tuning_state, static_cast<std::uint32_t>(command), Source::sdo,
        result);
  }
  show_tuning();
  return result;
}

void ServoCore::log_revert(Source source) {
  if (parameters_.state() != TuningState::none) {
    log(tuning_key, objects_.tuning_state, static_cast<std::uint32_t>(TuningCommand::revert),
        source, Abort::none);
  }
}

void ServoCore::revert_tuning(Source source) {
  log_revert(source);
  parameters_.tune(TuningCommand::revert, 0, axis_.may_heat());
  show_tuning();
}

/// Reverts the transaction of a client that is no longer there.
void ServoCore::watch_client() {
  if (left_alone_ && parameters_.state() == TuningState::on_trial) {
    return;
  }
  const std::uint64_t last_us = std::max(tuned_us_, node_.last_sdo_us());
  const std::uint64_t timeout_us = microseconds_of(objects_.client_timeout_s);
  if (parameters_.state() != TuningState::none && timeout_us != 0 &&
      timeout_us < now_us_ - last_us) {
    revert_tuning(Source::device);
  }
}

void ServoCore::show_tuning() {
  const auto bits = [](Key key) {
    return static_cast<std::uint32_t>(key.index) << 16U | static_cast<std::uint32_t>(key.sub) << 8U;
  };
  objects_.tuning_state = static_cast<std::uint8_t>(parameters_.state());
  objects_.remaining_s = parameters_.remaining_s();
  objects_.refused = bits(parameters_.refused());
  objects_.refused_other = bits(parameters_.refused_other());
}

void ServoCore::log(Key key, std::uint32_t before, std::uint32_t value, Source source,
                    Abort result) {
  log_.add({milliseconds_of(now_us_), key, source, before, value, result});
  objects_.changes = log_.count();
}

void ServoCore::note_change(Key key, std::uint32_t before, std::uint32_t value, Source source) {
  node_.touch();
  log(key, before, value, source, Abort::none);
}

// The bus.

void ServoCore::started(std::uint8_t /*node_id*/) {
  revert_tuning(Source::device);
  axis_.reset(parameters_.has_load_cell());
  recorder_.reset(config_.step_s);
  step_test_.reset();
  unlock(0);
  command_watch_.reset();
  latched_ = {};
  errors_ = 0;
  missed_ = silent_ = false;
  load_changes_ = true;
  objects_.changes = log_.count();
}

void ServoCore::nmt_changed(Nmt state) {
  constexpr std::uint16_t stopped_code = 0x8100;
  // Bit 9 of the statusword shows whether controlwords are carried out: by SDO in PRE-OPERATIONAL,
  // by SDO and PDO in OPERATIONAL.
  axis_.remote(state == Nmt::operational || state == Nmt::pre_operational);
  if (state == Nmt::initialising) {
    axis_.stop();
    revert_tuning(Source::device);
  } else if (state == Nmt::stopped) {
    axis_.connection_lost(stopped_code);
  }
}

void ServoCore::connection_lost(std::uint16_t code) {
  missed_ = true;
  axis_.connection_lost(code);
  revert_tuning(Source::device);
}

Abort ServoCore::may_request(Request /*request*/) const {
  return axis_.may_heat() ? Abort::state : Abort::none;
}

bool ServoCore::may_write(Level level) const {
  return static_cast<std::uint8_t>(level) <= objects_.level;
}

void ServoCore::written(Key key, std::uint32_t old_value, std::uint32_t value, Source source,
                        Abort result) {
  load_changes_ = true;
  log(key, old_value, key == access_key ? 0 : value, source, result);
}

bool ServoCore::is_fresh() const {
  switch (node_.supervision()) {
    case Supervision::alive:
      return true;
    case Supervision::gone:
      return config_.unattended && objects_.connection_option == 0;
    case Supervision::none:
      break;
  }
  return config_.unattended ||
         command_watch_.is_alive(now_us_, microseconds_of(objects_.command_source_timeout_s));
}

/// Reports heat without a command source, once, with the source that is missing. Losses that the
/// node detects arrive through connection_lost(); this function reports silence where nothing is
/// watched, a missing SYNC, and a watched source that has not come by the time the axis is enabled.
void ServoCore::watch_command_source() {
  const bool fresh = is_fresh();
  const bool gone = axis_.may_heat() && !fresh;
  silent_ = silent_ && !fresh;
  if (gone && !missed_) {
    const std::uint16_t missing = node_.missing();
    const std::uint16_t code = missing != 0 ? missing : heartbeat_lost;
    silent_ = true;
    node_.set_errors(errors());
    node_.emergency(code);
    connection_lost(code);
  }
  missed_ = gone;
}

FaultSet ServoCore::external() const {
  FaultSet set;
  set.add(Fault::bus_lost, axis_.bus_lost());
  set.add(Fault::duplicate_node, node_.is_duplicated());
  return set;
}

// Time.

void ServoCore::advance(std::uint64_t now_us) {
  const float dt_s = seconds_of(now_us - now_us_);
  now_us_ = now_us;
  node_.set_sdo_timeouts({microseconds_of(objects_.sdo_segment_timeout_s),
                          microseconds_of(objects_.sdo_client_timeout_s)});
  node_.advance(now_us);
  if (parameters_.tick(dt_s)) {
    log(tuning_key, static_cast<std::uint32_t>(TuningState::on_trial), 0, Source::device,
        Abort::none);
  }
  watch_client();
  watch_command_source();
  show_load();
  show_tuning();
  if (node_.state() == Nmt::initialising) {
    return;
  }
  axis_.set_reach(parameters_.reach());
  axis_.advance(now_us);
  const std::uint16_t own = axis_.take_own_fault();
  node_.set_errors(errors());
  if (own != 0 && !axis_.bus_lost()) {
    node_.emergency(own);
  }
}

/// The bits of 1001h: latched faults, the axis in Fault, a silent command source.
std::uint8_t ServoCore::errors() const {
  const bool faulty = axis_.state() == DriveState::fault || axis_.state() == DriveState::reacting;
  const std::uint16_t own = axis_.own_fault();
  unsigned bits = errors_;
  bits |= faulty ? register_of(objects_.error_code) : 0U;
  bits |= own != 0 ? register_of(own) : 0U;
  bits |= silent_ ? register_of(heartbeat_lost) : 0U;
  return static_cast<std::uint8_t>(bits);
}

void ServoCore::show_load() {
  if (!load_changes_) {
    return;
  }
  load_changes_ = false;
  const BusLoad load = node_.pdo_load(config_.step_s);
  objects_.pdo_load = {load.frames, 100 * load.bits / bits_per_s(node_.bit_rate())};
}

void ServoCore::publish(const StepReport& report) {
  signals_ = report.signals;
  objects_.limit_reasons = report.limit_reasons;
  objects_.warning_causes.at(report.told_count.place) = report.told_count.causes;
  objects_.device_state = static_cast<std::uint8_t>(report.state);
  objects_.first_cause = static_cast<std::uint8_t>(report.first_cause);
  show_faults(report);
  const FaultSet why =
      report.first_cause != Fault::none ? FaultSet(report.first_cause) : report.blocks;
  constexpr std::uint32_t planner = 1U << static_cast<unsigned>(LimitReason::trajectory) |
                                    1U << static_cast<unsigned>(LimitReason::min_current);
  axis_.feedback({report.state, !(report.active & blocking_faults).empty(),
                  !report.active.has(Fault::supply_low), !report.warnings.empty(),
                  (report.limit_reasons & ~planner) != 0, code_of(why.first()),
                  signals_[signal_index("position_m")], signals_[signal_index("velocity_m_s")],
                  signals_[signal_index("force_N")]});
  step_test_.step(signals_, report.dt_s, axis_);
  recorder_.record(signals_);
}

/// Sends an EMCY for each fault that has just been latched.
void ServoCore::show_faults(const StepReport& report) {
  const std::array<FaultSet, 4> sets{report.latched, report.active, report.warnings, report.blocks};
  for (std::size_t i = 0; i < sets.size(); ++i) {
    objects_.fault_bits[2 * i] = static_cast<std::uint32_t>(sets[i].bits());
    objects_.fault_bits[2 * i + 1] = static_cast<std::uint32_t>(sets[i].bits() >> 32U);
  }
  if (report.latched == latched_) {
    return;
  }
  errors_ = 0;
  for_each_fault(report.latched, [&](Fault fault) {
    errors_ = static_cast<std::uint8_t>(errors_ | register_of(code_of(fault)));
  });
  node_.set_errors(errors());
  for_each_fault(report.latched - latched_, [&](Fault fault) {
    node_.emergency(code_of(fault), static_cast<std::uint64_t>(fault));
  });
  latched_ = report.latched;
}

void ServoCore::set_timing(const LoopTiming& t) {
  objects_.steps = {t.steps, t.missed};
  objects_.timing_s = {t.mean_late_s, t.max_late_s, t.mean_busy_s, t.max_busy_s};
}

}  // namespace smaservo::canopen
