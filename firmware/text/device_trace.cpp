#include "firmware/text/device_trace.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "firmware/signals.hpp"
#include "firmware/text/device_names.hpp"

namespace smaservo::text {
namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 18U;

template <auto of>
void number(std::string& to, const Cycle& cycle) {
  append_number(to, of(cycle));
}
template <auto of>
void flag(std::string& to, const Cycle& cycle) {
  to += of(cycle) ? '1' : '0';
}
template <auto of>
void text(std::string& to, const Cycle& cycle) {
  to += of(cycle);
}
using T = const Cycle&;
using Columns = std::vector<DeviceColumn>;

template <std::size_t row>
constexpr DeviceColumn signal_column{
    signal_rows<double>[row].name,
    number<[](T t) { return signal_rows<double>[row].read({t.output, t.inputs, {}}); }>};

constexpr std::array outputs{
    signal_column<signal_index("drive_current_A")>,
    signal_column<signal_index("drive_voltage_V")>,
    DeviceColumn{"state", text<[](T t) { return state_name(t.output.state); }>, true},
    DeviceColumn{"mode", text<[](T t) { return mode_name(t.output.mode); }>, true},
    signal_column<signal_index("setpoint")>,
    signal_column<signal_index("reference")>,
    signal_column<signal_index("wanted_power_W")>,
    signal_column<signal_index("strain")>,
    signal_column<signal_index("strain_sd")>,
    signal_column<signal_index("wire_temperature_K")>,
    signal_column<signal_index("martensite")>,
    signal_column<signal_index("r_phase")>,
    DeviceColumn{"health", text<[](T t) { return health_name(t.output.estimate.health); }>, true},
    signal_column<signal_index("hot_spot_K")>,
    signal_column<signal_index("estimated_ambient_K")>,
    DeviceColumn{"limit_reasons",
                 text<[](T t) { return limit_reason_names(t.output.limit_reasons); }>, true},
    DeviceColumn{"active_faults", text<[](T t) { return names_of(t.output.active); }>, true},
    DeviceColumn{"latched_faults", text<[](T t) { return names_of(t.output.latched); }>, true},
    DeviceColumn{"first_cause", text<[](T t) { return fault_name(t.output.first_cause); }>, true},
    DeviceColumn{"warnings", text<[](T t) { return names_of(t.output.warnings); }>, true},
    DeviceColumn{"blocks", text<[](T t) { return names_of(t.output.blocks); }>, true},
};

}  // namespace

void append_number(std::string& to, double value) {
  if (std::isnan(value)) {
    return;
  }
  std::array<char, 32> digits{};
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  to.append(digits.data(), end);
}

Columns log_columns(bool supply, bool ambient, bool driver) {
  Columns all{
      {"time_s", number<[](T t) { return t.time_s; }>},
      {"fresh", flag<[](T t) { return t.inputs.fresh; }>},
      {"sequence", number<[](T t) { return static_cast<double>(t.inputs.sequence); }>},
      signal_column<signal_index("current_A")>,
      signal_column<signal_index("voltage_V")>,
      {"load_N", number<[](T t) { return t.inputs.sample.load_N; }>},
  };
  if (supply) {
    all.push_back(signal_column<signal_index("supply_V")>);
  }
  if (ambient) {
    all.push_back({"ambient_K", number<[](T t) { return t.inputs.ambient_K; }>});
  }
  if (driver) {
    all.push_back({"driver_K", number<[](T t) { return t.inputs.driver_K; }>});
  }
  const Columns rest{
      {"emergency_stop", flag<[](T t) { return t.inputs.emergency_stop; }>},
      {"driver_fault", flag<[](T t) { return t.inputs.driver_fault; }>},
      {"deadline_missed", flag<[](T t) { return t.inputs.deadline_missed; }>},
      {"external_faults", text<[](T t) { return names_of(t.inputs.external); }>, true},
      {"command_fresh", flag<[](T t) { return t.command.fresh; }>},
      {"command_arm", flag<[](T t) { return t.command.arm; }>},
      {"command_clear", flag<[](T t) { return t.command.clear_faults; }>},
      {"command_mode", text<[](T t) { return mode_name(t.command.mode); }>, true},
      {"command_setpoint", number<[](T t) { return t.command.setpoint; }>},
      {"command_proportional", number<[](T t) { return t.command.scale.proportional; }>},
      {"command_integral", number<[](T t) { return t.command.scale.integral; }>},
      {"command_derivative", number<[](T t) { return t.command.scale.derivative; }>},
  };
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

std::span<const DeviceColumn> output_columns() {
  return outputs;
}

DeviceRows::DeviceRows(Columns columns, const std::vector<std::string>& further)
    : columns_(std::move(columns)) {
  for (const DeviceColumn& column : columns_) {
    header_ += header_.empty() ? "" : ",";
    header_ += column.name;
  }
  for (const std::string& name : further) {
    header_ += ',' + name;
  }
  header_ += '\n';
}

void DeviceRows::append(std::string& to, const Cycle& cycle, std::string_view further) const {
  bool first = true;
  for (const DeviceColumn& column : columns_) {
    if (!first) {
      to += ',';
    }
    first = false;
    column.write(to, cycle);
  }
  to += further;
  to += '\n';
}

std::vector<hal::mcap::Kind> DeviceRows::kinds() const {
  std::vector<hal::mcap::Kind> all;
  all.reserve(columns_.size());
  for (const DeviceColumn& column : columns_) {
    all.push_back(column.is_text ? hal::mcap::Kind::text : hal::mcap::Kind::number);
  }
  return all;
}

DeviceTraceFile::DeviceTraceFile(const std::string& path, const hal::mcap::Origin& origin,
                                 Columns columns, const std::vector<std::string>& further)
    : rows_(std::move(columns), further),
      file_(path, origin, rows_.kinds()),
      buffer_(rows_.header()) {
  buffer_.reserve(2 * buffer_size);
}

void DeviceTraceFile::add(const Cycle& cycle, std::string_view further) {
  rows_.append(buffer_, cycle, further);
  if (buffer_.size() >= buffer_size) {
    file_.write(buffer_);
    buffer_.clear();
  }
}

void DeviceTraceFile::commit() {
  file_.write(buffer_);
  buffer_.clear();
  file_.commit();
}

}  // namespace smaservo::text
